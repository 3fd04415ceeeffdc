//! The frames of a recording, as a source: what was measured then is played anew. What the player did meanwhile (a pause,
//! another profile) is not in them; `gelpad replay` plays the session itself.

use std::collections::VecDeque;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use super::{Pace, Reading, Source, SourceError};
use crate::session::{Message, ReadError, Reader};
use crate::types::{Frame, Nanos};

/// A recording that is read as it plays.
pub struct RecordedFrames {
    path: PathBuf,
    reader: Reader<BufReader<File>>,
    channels: usize,
    frames: VecDeque<Frame>,
    last_ns: Nanos,
}

impl RecordedFrames {
    /// Opens a recording of frames of so many channels.
    ///
    /// # Errors
    /// A file that cannot be read or is no recording.
    pub fn open(path: &Path, channels: usize) -> Result<Self, SourceError> {
        let wrong = |error: ReadError| recording_error(path, error);
        let file = File::open(path).map_err(|error| wrong(ReadError::Io(error)))?;
        let (reader, _) = Reader::open(BufReader::new(file)).map_err(wrong)?;
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
    fn pace(&self) -> Pace {
        Pace::ByStamp
    }

    fn read(&mut self) -> Result<Reading, SourceError> {
        loop {
            if let Some(frame) = self.frames.pop_front() {
                let wrong = |why: &str| {
                    Ok(Reading::Skipped {
                        frames: 1,
                        reason: why.to_owned(),
                    })
                };
                if frame.volts.len() != self.channels {
                    return wrong("a frame of another pad");
                }
                if frame.t_ns < self.last_ns || frame.volts.iter().any(|volt| !volt.is_finite()) {
                    return wrong(
                        "a frame whose time runs backwards, or with a voltage that is no number",
                    );
                }
                self.last_ns = frame.t_ns;
                return Ok(Reading::Frame(frame));
            }
            match self.reader.next() {
                Ok(Some(Message::Frames(frames))) => self.frames = frames.into(),
                Ok(Some(Message::Control(control))) => return Ok(Reading::Control(control)),
                Ok(Some(_)) => {}
                // Cut at its end: all before was played.
                Ok(None) | Err(ReadError::Cut { .. }) => return Ok(Reading::End),
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
