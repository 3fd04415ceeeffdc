//! Makes another matrix aside while play goes on: when an electrode is lost or comes back.
//!
//! The engine says which weights it wants; the thread here builds for them, and what it built goes back in as an input like any other.

use std::io;
use std::sync::Arc;
use std::thread::{Builder, Thread};
use std::time::Duration;

use rtrb::{Consumer, Producer, RingBuffer};

use crate::touch::{Sensing, SensingBuilder};

/// A wish wakes the thread; by itself it only looks whether it is still wanted.
const LOOK: Duration = Duration::from_millis(500);

/// Hands weights to the thread that builds, and takes what it built.
pub(super) struct Rebuilder {
    wishes: Producer<Vec<f64>>,
    built: Consumer<Arc<Sensing>>,
    thread: Thread,
    waiting: bool,
}

impl Rebuilder {
    /// Starts the thread; it ends when this is dropped. `engine` is woken when something is built.
    pub(super) fn start(builder: SensingBuilder, engine: Thread) -> io::Result<Self> {
        let (wishes, wished) = RingBuffer::new(1);
        let (built_in, built) = RingBuffer::new(1);
        let thread = Builder::new()
            .name("matrix".to_owned())
            .spawn(move || build_all(&builder, wished, built_in, &engine))?
            .thread()
            .clone();
        Ok(Self {
            wishes,
            built,
            thread,
            waiting: false,
        })
    }

    /// Asks for weights, unless an answer is still awaited.
    pub(super) fn wish(&mut self, deviations: &[f64]) {
        if !self.waiting && self.wishes.push(deviations.to_vec()).is_ok() {
            self.waiting = true;
            self.thread.unpark();
        }
    }

    /// What was built since.
    pub(super) fn take(&mut self) -> Option<Arc<Sensing>> {
        let built = self.built.pop().ok()?;
        self.waiting = false;
        Some(built)
    }
}

impl Drop for Rebuilder {
    fn drop(&mut self) {
        // The thread looks for its ends when it wakes.
        self.thread.unpark();
    }
}

fn build_all(
    builder: &SensingBuilder,
    mut wished: Consumer<Vec<f64>>,
    mut built: Producer<Arc<Sensing>>,
    engine: &Thread,
) {
    while !wished.is_abandoned() {
        match wished.pop() {
            Ok(deviations) => match builder.build(&deviations) {
                Ok(sensing) => {
                    let _ = built.push(Arc::new(sensing));
                    engine.unpark();
                }
                Err(error) => tracing::error!("no matrix without the lost electrodes: {error}"),
            },
            Err(_) => std::thread::park_timeout(LOOK),
        }
    }
}
