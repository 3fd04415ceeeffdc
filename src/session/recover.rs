//! Copies a recording: packed when it has ended, or as much of a damaged one as can be read.

use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Seek};
use std::path::Path;

use super::message::{Gap, Message};
use super::{ReadError, Reader, Setup, WriteError, Writer};

/// Why a copy could not be made.
#[derive(Debug, thiserror::Error)]
pub enum CopyError {
    /// Nothing can be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The copy cannot be written.
    #[error("the copy cannot be written: {}", .0.reason())]
    Write(#[from] WriteError),
    /// A file cannot be made, or renamed.
    #[error("the copy cannot be written: {0}")]
    File(#[from] std::io::Error),
}

/// What a damaged file held.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Salvage {
    /// Frames that were saved.
    pub frames: u64,
    /// Other inputs of the engine that were saved.
    pub inputs: u64,
    /// Events that were saved.
    pub events: u64,
    /// Inputs that the recorder itself had to leave out.
    pub left_out: u64,
    /// Things that could not be read.
    pub losses: u64,
    /// The first of them, in words.
    pub notes: Vec<String>,
    /// Whether the file was closed as it should be.
    pub was_whole: bool,
}

impl Salvage {
    /// Whether anything is known to be missing.
    #[must_use]
    pub fn has_lost(&self) -> bool {
        self.losses + self.left_out > 0
    }
}

/// Saves what a damaged recording holds, packed: written beside first, then renamed.
///
/// # Errors
/// A file of which nothing can be saved; a copy that cannot be written.
pub fn recover(from: &Path, to: &Path) -> Result<Salvage, CopyError> {
    let (reader, setup) = Reader::salvage(open(from)?)?;
    copy(reader, &setup, to)
}

/// Packs a recording in its place. It stays as it was until the packed one is whole.
///
/// # Errors
/// As [`recover`]; and anything that is wrong with the recording.
pub fn pack(path: &Path) -> Result<(), CopyError> {
    let (reader, setup) = Reader::open(open(path)?)?;
    copy(reader, &setup, path).map(|_| ())
}

fn open(path: &Path) -> Result<BufReader<File>, ReadError> {
    File::open(path).map(BufReader::new).map_err(ReadError::Io)
}

fn copy<R: Read + Seek>(
    mut reader: Reader<R>,
    setup: &Setup,
    to: &Path,
) -> Result<Salvage, CopyError> {
    let mut beside = to.as_os_str().to_owned();
    beside.push(".part");
    let beside = Path::new(&beside);
    let outcome = copy_into(&mut reader, setup, beside);
    let finished = outcome.and_then(|salvage| {
        std::fs::rename(beside, to)?;
        Ok(salvage)
    });
    if finished.is_err() {
        // Half a copy helps nobody; what it was made of is still there.
        let _ = std::fs::remove_file(beside);
    }
    finished
}

fn copy_into<R: Read + Seek>(
    reader: &mut Reader<R>,
    setup: &Setup,
    to: &Path,
) -> Result<Salvage, CopyError> {
    let mut salvage = Salvage::default();
    let mut writer = Writer::packed(BufWriter::new(File::create(to)?), setup)?;
    let mut known_losses = 0;
    while let Some(message) = reader.next()? {
        let (losses, _) = reader.losses();
        if losses > known_losses {
            known_losses = losses;
            writer.write(&Message::Gap(Gap { inputs: 0 }))?;
        }
        match &message {
            Message::Matrix(name) => match reader.attachment(&name.attachment) {
                Some(sensing) => {
                    salvage.inputs += 1;
                    writer.matrix(sensing)?;
                }
                None => writer.write(&Message::Gap(Gap { inputs: 1 }))?,
            },
            _ => writer.write(&message)?,
        }
        match &message {
            Message::Frames(frames) => salvage.frames += frames.len() as u64,
            Message::Gap(gap) => salvage.left_out += gap.inputs.max(1),
            Message::Event(_) => salvage.events += 1,
            Message::Touches(_) | Message::Matrix(_) => {}
            _ => salvage.inputs += 1,
        }
    }
    let file = writer.finish()?;
    file.into_inner()
        .map_err(std::io::IntoInnerError::into_error)?
        .sync_all()?;
    let (losses, notes) = reader.losses();
    salvage.losses = losses;
    salvage.notes = notes.to_vec();
    salvage.was_whole = reader.is_whole();
    Ok(salvage)
}
