//! Reads a recording ahead of the engine, on a thread of its own: unpacking costs the engine nothing.

use std::fs::File;
use std::io::BufReader;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::{Builder, JoinHandle};

use crate::tape::{Played, Player, PlayerError};

/// Things that are handed over at once ...
const BATCH: usize = 64;
/// ... and batches that may wait.
const BATCHES: usize = 16;

type Batch = Vec<Result<Played, PlayerError>>;

/// A recording that is read ahead.
pub(super) struct Ahead {
    batches: Option<Receiver<Batch>>,
    batch: std::vec::IntoIter<Result<Played, PlayerError>>,
    reader: Option<JoinHandle<bool>>,
    is_whole: bool,
}

impl Ahead {
    pub(super) fn start(mut player: Player<BufReader<File>>) -> std::io::Result<Self> {
        let (batches_in, batches) = sync_channel(BATCHES);
        let reader = Builder::new().name("reader".to_owned()).spawn(move || {
            loop {
                let mut batch = Vec::with_capacity(BATCH);
                let goes_on = fill(&mut player, &mut batch);
                if batches_in.send(batch).is_err() || !goes_on {
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

    /// What comes next; none at the end.
    pub(super) fn next(&mut self) -> Result<Option<Played>, PlayerError> {
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

    /// Whether the file was closed as it should be: known at its end.
    pub(super) fn is_whole(&self) -> bool {
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

impl Drop for Ahead {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Fills a batch; whether there is more.
fn fill(player: &mut Player<BufReader<File>>, batch: &mut Batch) -> bool {
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
