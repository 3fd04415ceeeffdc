//! Reads and decompresses a recording on its own thread, ahead of the engine.

use std::fs::File;
use std::io::BufReader;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::{Builder, JoinHandle};

use crate::tape::{PlayerError, RecordedItem, RecordingPlayer};

/// Messages per batch.
const BATCH: usize = 64;
/// Batches that may wait.
const BATCHES: usize = 16;

type Batch = Vec<Result<RecordedItem, PlayerError>>;

/// A recording that is read ahead.
pub(crate) struct ReadAhead {
    batches: Option<Receiver<Batch>>,
    batch: std::vec::IntoIter<Result<RecordedItem, PlayerError>>,
    reader: Option<JoinHandle<bool>>,
    is_whole: bool,
}

impl ReadAhead {
    /// Starts the reading thread.
    pub(crate) fn start(mut player: RecordingPlayer<BufReader<File>>) -> std::io::Result<Self> {
        let (batches_in, batches) = sync_channel(BATCHES);
        let reader = Builder::new().name("reader".to_owned()).spawn(move || {
            loop {
                let mut batch = Vec::with_capacity(BATCH);
                let has_more = fill(&mut player, &mut batch);
                if batches_in.send(batch).is_err() || !has_more {
                    return player.is_whole();
                }
            }
        })?;
        Ok(Self {
            batches: Some(batches),
            batch: Vec::new().into_iter(),
            reader: Some(reader),
            is_whole: false,
        })
    }

    /// The next message; none at the end.
    #[allow(
        clippy::should_implement_trait,
        reason = "errors end it: a loop with `?` reads it"
    )]
    pub(crate) fn next(&mut self) -> Result<Option<RecordedItem>, PlayerError> {
        loop {
            if let Some(played) = self.batch.next() {
                return played.map(Some);
            }
            match self.batches.as_ref().map(Receiver::recv) {
                Some(Ok(batch)) => self.batch = batch.into_iter(),
                _ => {
                    self.stop();
                    return Ok(None);
                }
            }
        }
    }

    /// Whether the file was closed properly; known at its end.
    pub(crate) fn is_whole(&self) -> bool {
        self.is_whole
    }

    fn stop(&mut self) {
        // Without a receiver the thread ends at its next batch.
        self.batches = None;
        if let Some(reader) = self.reader.take() {
            self.is_whole = reader.join().unwrap_or(false);
        }
    }
}

impl Drop for ReadAhead {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Fills a batch; returns whether there is more.
fn fill(player: &mut RecordingPlayer<BufReader<File>>, batch: &mut Batch) -> bool {
    while batch.len() < BATCH {
        match player.next() {
            Ok(Some(played)) => batch.push(Ok(played)),
            Ok(None) => return false,
            Err(error) => {
                batch.push(Err(error));
                return false;
            }
        }
    }
    true
}
