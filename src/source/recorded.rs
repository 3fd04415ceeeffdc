//! The frames of a recording as a source. What the player did during the recording (a pause, another profile)
//! is not part of them; `gelpad replay` plays the whole session.

use std::collections::VecDeque;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use super::{Source, SourceError, SourcePace, SourceReading};
use crate::session::{Message, ReadError, Reader};
use crate::types::{Frame, Nanos};

/// A recording that is read while it plays.
pub struct RecordedFrames {
    path: PathBuf,
    reader: Reader<BufReader<File>>,
    channels: usize,
    frames: VecDeque<Frame>,
    last_ns: Nanos,
}

impl RecordedFrames {
    /// Opens a recording of frames with this number of channels.
    ///
    /// # Errors
    /// The file cannot be read or is not a recording.
    pub fn open(path: &Path, channels: usize) -> Result<Self, SourceError> {
        let failed = |error: ReadError| recording_error(path, error);
        let file = File::open(path).map_err(|error| failed(ReadError::Io(error)))?;
        let (reader, _) = Reader::open(BufReader::new(file)).map_err(failed)?;
        Ok(Self {
            path: path.to_owned(),
            reader,
            channels,
            frames: VecDeque::new(),
            last_ns: 0,
        })
    }
}

impl Source for RecordedFrames {
    fn pace(&self) -> SourcePace {
        SourcePace::ByStamp
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        loop {
            if let Some(frame) = self.frames.pop_front() {
                let skipped = |why: &str| {
                    Ok(SourceReading::Skipped {
                        frames: 1,
                        reason: why.to_owned(),
                    })
                };
                if frame.volts.len() != self.channels {
                    return skipped("a frame of another pad");
                }
                if frame.t_ns < self.last_ns || frame.volts.iter().any(|volt| !volt.is_finite()) {
                    return skipped(
                        "a frame whose time runs backwards, or with a voltage that is not a number",
                    );
                }
                self.last_ns = frame.t_ns;
                return Ok(SourceReading::Frame(frame));
            }
            match self.reader.next() {
                Ok(Some(Message::Frames(frames))) => self.frames = frames.into(),
                Ok(Some(Message::Control(control))) => return Ok(SourceReading::Control(control)),
                Ok(Some(_)) => {}
                // The file is truncated: everything before was played.
                Ok(None) | Err(ReadError::Cut { .. }) => return Ok(SourceReading::End),
                Err(error) => return Err(recording_error(&self.path, error)),
            }
        }
    }
}

fn recording_error(path: &Path, error: ReadError) -> SourceError {
    SourceError::Recording {
        path: path.to_owned(),
        error,
    }
}
