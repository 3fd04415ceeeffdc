//! Copies a recording into a packed one: a complete recording, or what can be read of a damaged one.

use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Seek};
use std::path::Path;

use super::message::{Gap, Message};
use super::read::{ReadError, Reader};
use super::setup::{Setup, SetupParts};
use super::write::{WriteError, Writer};
use crate::files::{self, FileError};

/// Why a copy could not be made.
#[derive(Debug, thiserror::Error)]
pub enum CopyError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The setup cannot be completed.
    #[error("nothing can be replayed: {0}")]
    Setup(String),
    /// The copy cannot be written.
    #[error("the copy cannot be written: {}", .0.reason())]
    Write(#[from] WriteError),
    /// A file cannot be created or renamed.
    #[error(transparent)]
    File(#[from] FileError),
    /// A copy that could not be replayed: it is not kept.
    #[error("only {} frames can be read, and the first {least} are the reference: nothing is saved{}", .report.frames, .report.lost_lines())]
    TooFew {
        /// What could be read.
        report: Box<RecoveryReport>,
        /// Frames that a replay needs.
        least: u64,
    },
}

/// Makes a damaged recording one that replays.
pub trait Restore {
    /// Completes a setup of which parts cannot be read.
    ///
    /// # Errors
    /// No engine can be built.
    fn setup(&mut self, parts: SetupParts) -> Result<Setup, String>;

    /// Checks a message; `matrix` are the bytes that a matrix message names. A refused message counts as lost.
    ///
    /// # Errors
    /// Replay would end there.
    fn check(&mut self, message: &Message, matrix: Option<&[u8]>) -> Result<(), String>;
}

/// Takes everything as it is.
struct Unchanged;

impl Restore for Unchanged {
    fn setup(&mut self, parts: SetupParts) -> Result<Setup, String> {
        parts.complete().map_err(str::to_owned)
    }

    fn check(&mut self, _: &Message, _: Option<&[u8]>) -> Result<(), String> {
        Ok(())
    }
}

/// What was saved of a recording.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecoveryReport {
    /// Frames saved.
    pub frames: u64,
    /// States of gamepads saved.
    pub controls: u64,
    /// Other engine inputs saved.
    pub inputs: u64,
    /// Events saved.
    pub events: u64,
    /// Inputs that the recorder dropped.
    pub dropped_inputs: u64,
    /// Places that could not be read.
    pub losses: u64,
    /// Descriptions of the first of them.
    pub notes: Vec<String>,
    /// Whether the file was closed properly.
    pub was_whole: bool,
}

impl RecoveryReport {
    /// Whether the recording is incomplete.
    #[must_use]
    pub fn is_incomplete(&self) -> bool {
        self.losses + self.dropped_inputs > 0
    }

    /// What was lost: the first places, each as a new line, and the number of the others.
    #[must_use]
    pub fn lost_lines(&self) -> String {
        let mut lines: String = self
            .notes
            .iter()
            .map(|note| format!("\nlost: {note}"))
            .collect();
        let printed = self.notes.len() as u64;
        if self.losses > printed {
            lines.push_str(&format!("\nlost: and {} more", self.losses - printed));
        }
        lines
    }
}

/// Saves what can be read of a recording, packed: completely or not at all (see [`files`]). Of a pad, at least `least_frames` must
/// be readable.
///
/// # Errors
/// A file of which nothing can be read or replayed; a copy that cannot be written.
pub fn recover(
    from: &Path,
    to: &Path,
    restore: &mut dyn Restore,
    least_frames: u64,
) -> Result<RecoveryReport, CopyError> {
    let (mut reader, parts) = Reader::salvage(open(from)?)?;
    let setup = restore.setup(parts).map_err(CopyError::Setup)?;
    files::write_seekable(to, |file| {
        let report = copy_into(&mut reader, &setup, file, restore)?;
        if report.controls == 0 && report.frames < least_frames {
            return Err(CopyError::TooFew {
                report: Box::new(report),
                least: least_frames,
            });
        }
        Ok(report)
    })
}

/// Packs a recording in place. The original stays until the packed file is complete.
///
/// # Errors
/// As [`recover`]; any damage of the recording.
pub fn pack(path: &Path) -> Result<(), CopyError> {
    let (mut reader, setup) = Reader::open(open(path)?)?;
    files::write_seekable(path, |file| {
        copy_into(&mut reader, &setup, file, &mut Unchanged).map(|_| ())
    })
}

fn open(path: &Path) -> Result<BufReader<File>, ReadError> {
    File::open(path).map(BufReader::new).map_err(ReadError::Io)
}

fn copy_into<R: Read + Seek>(
    reader: &mut Reader<R>,
    setup: &Setup,
    to: File,
    restore: &mut dyn Restore,
) -> Result<RecoveryReport, CopyError> {
    let mut report = RecoveryReport::default();
    let mut writer = Writer::packed(BufWriter::new(to), setup)?;
    let mut known_losses = 0;
    while let Some(message) = reader.next()? {
        let matrix = match &message {
            Message::Matrix(name) => reader.attachment(&name.attachment),
            _ => None,
        };
        let refused = restore.check(&message, matrix).err();
        if let Some(why) = &refused {
            reader.reject(why);
        }
        let (losses, _) = reader.losses();
        if losses > known_losses {
            known_losses = losses;
            writer.write(&Message::Gap(Gap { inputs: 0 }))?;
        }
        if refused.is_some() {
            continue;
        }
        match &message {
            Message::Matrix(name) => match reader.attachment(&name.attachment) {
                Some(sensing) => {
                    report.inputs += 1;
                    writer.write_matrix(sensing)?;
                }
                None => writer.write(&Message::Gap(Gap { inputs: 1 }))?,
            },
            _ => writer.write(&message)?,
        }
        match &message {
            Message::Frames(frames) => report.frames += frames.len() as u64,
            Message::Parts(parts) => {
                report.frames += parts.iter().filter(|part| part.first == 0).count() as u64;
            }
            Message::Gap(gap) => report.dropped_inputs += gap.inputs.max(1),
            Message::Event(_) => report.events += 1,
            Message::Control(_) => report.controls += 1,
            Message::Touches(_) | Message::TouchBlock(_) | Message::Matrix(_) => {}
            _ => report.inputs += 1,
        }
    }
    let file = writer.finish()?;
    file.into_inner()
        .map_err(|error| WriteError::from(mcap::McapError::from(error.into_error())))?;
    let (losses, notes) = reader.losses();
    report.losses = losses;
    report.notes = notes.to_vec();
    report.was_whole = reader.is_whole();
    Ok(report)
}
