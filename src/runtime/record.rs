//! The recorder's thread: every step of the engine to a file, flushed as it comes, packed when the session ends.
//!
//! The engine never waits for a disk: steps queue up, and one that finds the queue full is left out, which is said
//! and marked in the file. A file that cannot be written any further (a full disk) ends after its last whole
//! step, which is said at once; play goes on.

use std::fs::File;
use std::io::{BufWriter, Seek as _};
use std::path::{Path, PathBuf};
use std::thread::{Builder, JoinHandle, Thread};

use rtrb::{Consumer, Producer, RingBuffer};

use super::NAP;
use super::listen::{Listener, Step};
use crate::engine::Input;
use crate::session::{self, Setup, WriteError};
use crate::tape::Scribe;
use crate::types::{Event, Touch};

/// Steps that may wait for the disk: a second at 1000 frames/s.
const STEP_QUEUE: usize = 1024;

/// Why no recording begins.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be recorded to: {why}", path.display())]
pub struct RecordError {
    path: PathBuf,
    why: String,
}

/// How a recording went.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecordReport {
    /// Frames that it holds.
    pub frames: u64,
    /// Inputs that it does not hold.
    pub left_out: u64,
    /// Why it ended early, if it did.
    pub error: Option<String>,
}

/// A recording under way.
pub struct Recorder {
    thread: JoinHandle<RecordReport>,
}

impl Recorder {
    /// Waits until the file is packed; whoever told of steps must be gone by then.
    #[must_use]
    pub fn join(self) -> RecordReport {
        self.thread.join().unwrap_or_else(|_| RecordReport {
            error: Some("a bug in gelpad ended its recorder".to_owned()),
            ..RecordReport::default()
        })
    }
}

/// Begins a recording: writes what the engine is made of, and gives who is to be told of its steps.
///
/// # Errors
/// A file that cannot be written; no thread.
pub fn record(path: &Path, setup: &Setup) -> Result<(Box<dyn Listener>, Recorder), RecordError> {
    let wrong = |why: String| RecordError {
        path: path.to_owned(),
        why,
    };
    let file = File::create(path).map_err(|error| wrong(error.to_string()))?;
    let tape = Tape::begin(file, path, setup).map_err(|error| wrong(error.reason()))?;
    let (steps_in, steps) = RingBuffer::new(STEP_QUEUE);
    let thread = Builder::new()
        .name("recorder".to_owned())
        .spawn(move || tape.run(steps))
        .map_err(|error| wrong(error.to_string()))?;
    let tap = Tap {
        steps: steps_in,
        thread: thread.thread().clone(),
        left_out: 0,
    };
    Ok((Box::new(tap), Recorder { thread }))
}

/// What the recorder needs of a step.
enum Noted {
    Step {
        input: Input,
        touches: Vec<Touch>,
        events: Vec<Event>,
    },
    /// So many steps were left out here.
    LeftOut(u64),
}

/// The engine's end of the queue.
struct Tap {
    steps: Producer<Noted>,
    thread: Thread,
    left_out: u64,
}

impl Listener for Tap {
    fn step(&mut self, step: &Step<'_>) {
        if self.left_out > 0 && self.steps.push(Noted::LeftOut(self.left_out)).is_ok() {
            self.left_out = 0;
        }
        let noted = Noted::Step {
            input: step.input.clone(),
            touches: step.touches.to_vec(),
            events: step.events.to_vec(),
        };
        if self.left_out > 0 || self.steps.push(noted).is_err() {
            self.left_out += 1;
        }
        self.thread.unpark();
    }
}

impl Drop for Tap {
    fn drop(&mut self) {
        if self.left_out > 0 {
            // Without room even for this the file ends early by as much.
            let _ = self.steps.push(Noted::LeftOut(self.left_out));
        }
        self.thread.unpark();
    }
}

/// The recorder's end.
struct Tape {
    path: PathBuf,
    /// The file again, to be cut after the last whole step.
    file: File,
    scribe: Option<Scribe<BufWriter<File>>>,
    /// Length of the file up to the last whole step.
    whole: u64,
    report: RecordReport,
}

impl Tape {
    fn begin(file: File, path: &Path, setup: &Setup) -> Result<Self, WriteError> {
        let again = file.try_clone().map_err(mcap::McapError::from)?;
        let mut scribe = Scribe::live(BufWriter::new(file), setup)?;
        scribe.flush()?;
        let mut tape = Self {
            path: path.to_owned(),
            file: again,
            scribe: Some(scribe),
            whole: 0,
            report: RecordReport::default(),
        };
        tape.mark_whole();
        Ok(tape)
    }

    fn run(mut self, mut steps: Consumer<Noted>) -> RecordReport {
        loop {
            match steps.pop() {
                Ok(noted) => self.take(noted),
                Err(_) if steps.is_abandoned() && steps.is_empty() => break,
                Err(_) => std::thread::park_timeout(NAP),
            }
        }
        self.end()
    }

    fn take(&mut self, noted: Noted) {
        if self.scribe.is_none() {
            self.report.left_out += 1;
            return;
        }
        match self.put(&noted) {
            Ok(()) => {
                self.mark_whole();
                match noted {
                    Noted::Step {
                        input: Input::Frame(_),
                        ..
                    } => self.report.frames += 1,
                    Noted::LeftOut(steps) => {
                        self.report.left_out += steps;
                        tracing::error!(
                            "the disk is too slow: {steps} inputs are missing in the recording"
                        );
                    }
                    Noted::Step { .. } => {}
                }
            }
            Err(error) => {
                self.report.left_out += 1;
                self.give_up(&error.reason());
            }
        }
    }

    fn put(&mut self, noted: &Noted) -> Result<(), WriteError> {
        let Some(scribe) = &mut self.scribe else {
            return Ok(());
        };
        match noted {
            Noted::LeftOut(steps) => scribe.gap(*steps)?,
            Noted::Step {
                input,
                touches,
                events,
            } => scribe.step(input, touches, events)?,
        }
        scribe.flush()
    }

    fn mark_whole(&mut self) {
        if let Ok(length) = self.file.stream_position() {
            self.whole = length;
        }
    }

    /// The file ends after its last whole step.
    fn give_up(&mut self, why: &str) {
        tracing::error!(
            "{}: {why}: the recording ends here, play goes on",
            self.path.display()
        );
        self.report.error = Some(why.to_owned());
        // The scribe tries to end the file when it goes; what comes of that is cut off again.
        self.scribe = None;
        if let Err(error) = self.file.set_len(self.whole) {
            tracing::error!("{}: its end is not whole: {error}", self.path.display());
        }
    }

    fn end(mut self) -> RecordReport {
        let Some(scribe) = self.scribe.take() else {
            return self.report;
        };
        // A file without an end is whole up to there: nothing that was played is missing.
        let finished = scribe.finish().map_err(|error| error.reason());
        let flushed =
            finished.and_then(|file| file.into_inner().map_err(|error| error.to_string()));
        if let Err(why) = flushed {
            tracing::warn!("{}: left without an end: {why}", self.path.display());
            let _ = self.file.set_len(self.whole);
            return self.report;
        }
        if let Err(error) = session::pack(&self.path) {
            tracing::warn!("{}: left unpacked: {error}", self.path.display());
        }
        self.report
    }
}
