//! The recorder's thread: writes every step of the engine to a file, flushed step by step and packed at the end.
//!
//! The engine never waits for the disk. Steps are queued; if the queue is full, a step is omitted, which is
//! logged and marked in the file. If the file cannot be written any further (disk full), it ends after its
//! last complete step, an error is logged, and play continues.

use std::fs::File;
use std::io::{BufWriter, ErrorKind, Seek as _};
use std::path::{Path, PathBuf};
use std::thread::{JoinHandle, Thread};

use rtrb::{Consumer, Producer, RingBuffer};

use super::listen::{EngineStep, StepListener};
use super::{NAP, spawn};
use crate::engine::Input;
use crate::files;
use crate::session::{self, Setup, WriteError};
use crate::tape::SessionWriter;
use crate::types::{Event, Touch};

/// Steps that may wait for the disk: one second at 1000 frames/s, or at 60 frames/s in parts.
const STEP_QUEUE: usize = 1024;
const EXISTS: &str = "the file exists\n  help: name another file, or replace it with --force";

/// The recording cannot be started.
#[derive(Debug, thiserror::Error)]
#[error("cannot record to {}: {why}", path.display())]
pub struct RecordError {
    path: PathBuf,
    why: String,
}

/// What to do with a file that stands where a recording goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExistingFile {
    /// Refuse to record.
    #[default]
    Refuse,
    /// Replace it, unless another gelpad is writing it.
    Replace,
}

/// The result of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecordReport {
    /// Frames in the file.
    pub frames: u64,
    /// Inputs that were omitted.
    pub omitted_steps: u64,
    /// Why the file ended early.
    pub error: Option<String>,
}

/// A recording in progress.
pub struct Recorder {
    thread: JoinHandle<RecordReport>,
}

impl Recorder {
    /// Waits until the file is packed. The listener must have been dropped before.
    #[must_use]
    pub fn join(self) -> RecordReport {
        self.thread.join().unwrap_or_else(|_| RecordReport {
            error: Some("the recorder crashed (a bug in gelpad)".to_owned()),
            ..RecordReport::default()
        })
    }
}

/// Starts a recording: writes the setup of the engine and returns the listener for its steps.
///
/// # Errors
/// The file exists or cannot be written, or no thread be started.
pub fn start_recording(
    path: &Path,
    setup: &Setup,
    existing: ExistingFile,
) -> Result<(Box<dyn StepListener>, Recorder), RecordError> {
    let failed = |why: String| RecordError {
        path: path.to_owned(),
        why,
    };
    let file = create(path, existing)?;
    let recording =
        RecordingFile::create(file, path, setup).map_err(|error| failed(error.reason()))?;
    let (steps_in, steps) = RingBuffer::new(STEP_QUEUE);
    let thread = spawn("recorder", move || recording.run(steps))
        .map_err(|error| failed(error.to_string()))?;
    let tap = RecordingListener {
        steps: steps_in,
        thread: thread.thread().clone(),
        omitted: 0,
    };
    Ok((Box::new(tap), Recorder { thread }))
}

/// Checks, before a game is prepared, that a recording can be written there.
///
/// # Errors
/// What stands there must not be replaced.
pub fn check_recording(path: &Path, existing: ExistingFile) -> Result<(), RecordError> {
    let refused = |why: &str| RecordError {
        path: path.to_owned(),
        why: why.to_owned(),
    };
    let Ok(found) = path.symlink_metadata() else {
        return Ok(());
    };
    if existing == ExistingFile::Refuse {
        return Err(refused(EXISTS));
    }
    // A link is replaced through its target, which may be missing.
    match path.metadata() {
        Ok(target) if target.is_file() => Ok(()),
        _ if found.is_file() => Ok(()),
        _ => Err(refused(
            "it is not a regular file\n  help: a recording needs a file, since it is compressed when it ends",
        )),
    }
}

/// Creates the file, or empties an existing one, and locks it.
fn create(path: &Path, existing: ExistingFile) -> Result<File, RecordError> {
    check_recording(path, existing)?;
    let failed = |why: String| RecordError {
        path: path.to_owned(),
        why,
    };
    let mut options = File::options();
    options.write(true);
    match existing {
        ExistingFile::Refuse => options.create_new(true),
        ExistingFile::Replace => options.create(true).truncate(false),
    };
    let file = options.open(path).map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => failed(EXISTS.to_owned()),
        _ => failed(error.to_string()),
    })?;
    // Emptied only once no other gelpad writes it.
    files::lock(&file)
        .and_then(|()| file.set_len(0))
        .map_err(|error| failed(error.to_string()))?;
    Ok(file)
}

/// An entry of the queue.
enum QueuedStep {
    Step {
        input: Input,
        touches: Vec<Touch>,
        events: Vec<Event>,
    },
    /// Number of steps that were omitted here.
    Omitted(u64),
}

/// The engine's end of the queue.
struct RecordingListener {
    steps: Producer<QueuedStep>,
    thread: Thread,
    omitted: u64,
}

impl StepListener for RecordingListener {
    fn on_step(&mut self, step: &EngineStep<'_>) {
        if self.omitted > 0 && self.steps.push(QueuedStep::Omitted(self.omitted)).is_ok() {
            self.omitted = 0;
        }
        let step = QueuedStep::Step {
            input: step.input.clone(),
            touches: step.touches.to_vec(),
            events: step.events.to_vec(),
        };
        if self.omitted > 0 || self.steps.push(step).is_err() {
            self.omitted += 1;
        }
        self.thread.unpark();
    }
}

impl Drop for RecordingListener {
    fn drop(&mut self) {
        if self.omitted > 0 {
            // If even this finds no room, the file ends that much earlier.
            let _ = self.steps.push(QueuedStep::Omitted(self.omitted));
        }
        self.thread.unpark();
    }
}

/// Whether an input is a frame, or the first part of one.
fn begins_frame(input: &Input) -> bool {
    match input {
        Input::Frame(_) => true,
        Input::Part(part) => part.first == 0,
        _ => false,
    }
}

/// The recorder's end of the queue, and the file.
struct RecordingFile {
    path: PathBuf,
    /// A second handle of the file, to truncate it after the last complete step.
    file: File,
    writer: Option<SessionWriter<BufWriter<File>>>,
    /// Length of the file up to the last complete step, bytes.
    complete_len: u64,
    report: RecordReport,
}

impl RecordingFile {
    fn create(file: File, path: &Path, setup: &Setup) -> Result<Self, WriteError> {
        let duplicate = file.try_clone().map_err(mcap::McapError::from)?;
        let mut writer = SessionWriter::live(BufWriter::new(file), setup)?;
        writer.flush()?;
        let mut recording = Self {
            path: path.to_owned(),
            file: duplicate,
            writer: Some(writer),
            complete_len: 0,
            report: RecordReport::default(),
        };
        recording.mark_complete();
        Ok(recording)
    }

    fn run(mut self, mut steps: Consumer<QueuedStep>) -> RecordReport {
        loop {
            match steps.pop() {
                Ok(step) => self.take_step(step),
                Err(_) if steps.is_abandoned() && steps.is_empty() => break,
                Err(_) => std::thread::park_timeout(NAP),
            }
        }
        self.finish()
    }

    fn take_step(&mut self, step: QueuedStep) {
        if self.writer.is_none() {
            self.report.omitted_steps += 1;
            return;
        }
        match self.write(&step) {
            Ok(()) => {
                self.mark_complete();
                match step {
                    QueuedStep::Step { input, .. } => {
                        self.report.frames += u64::from(begins_frame(&input));
                    }
                    QueuedStep::Omitted(steps) => {
                        self.report.omitted_steps += steps;
                        tracing::error!(
                            "the disk is too slow: {steps} inputs are missing in the recording"
                        );
                    }
                }
            }
            Err(error) => {
                self.report.omitted_steps += 1;
                self.give_up(&error.reason());
            }
        }
    }

    fn write(&mut self, step: &QueuedStep) -> Result<(), WriteError> {
        let Some(writer) = &mut self.writer else {
            return Ok(());
        };
        match step {
            QueuedStep::Omitted(steps) => writer.write_gap(*steps)?,
            QueuedStep::Step {
                input,
                touches,
                events,
            } => writer.write_step(input, touches, events)?,
        }
        writer.flush()
    }

    fn mark_complete(&mut self) {
        if let Ok(length) = self.file.stream_position() {
            self.complete_len = length;
        }
    }

    /// Ends the file after its last complete step.
    fn give_up(&mut self, why: &str) {
        tracing::error!(
            "{}: {why}: the recording ends here, play goes on",
            self.path.display()
        );
        self.report.error = Some(why.to_owned());
        // Dropping the writer writes an end of file, which is truncated again.
        self.writer = None;
        if let Err(error) = self.file.set_len(self.complete_len) {
            tracing::error!(
                "{}: the last step may be incomplete: {error}",
                self.path.display()
            );
        }
    }

    fn finish(mut self) -> RecordReport {
        let Some(writer) = self.writer.take() else {
            return self.report;
        };
        // Without an end of file the recording is still readable: no step is missing.
        let finished = writer.finish().map_err(|error| error.reason());
        let flushed =
            finished.and_then(|file| file.into_inner().map_err(|error| error.to_string()));
        if let Err(why) = flushed {
            tracing::warn!(
                "{}: written without an end of file: {why}",
                self.path.display()
            );
            let _ = self.file.set_len(self.complete_len);
            return self.report;
        }
        if let Err(error) = session::pack(&self.path) {
            tracing::warn!("{}: not compressed: {error}", self.path.display());
        }
        self.report
    }
}
