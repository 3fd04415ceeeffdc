//! The frames of a recording as a source. What the player did during the recording (a pause, another profile)
//! is not part of them; `gelpad replay` plays the whole session.

use std::collections::VecDeque;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use super::{Source, SourceError, SourcePace, SourceReading};
use crate::session::{Message, ReadError, Reader};
use crate::types::{Frame, FrameAssembler, Nanos, Part};

/// A recording that is read while it plays.
pub struct RecordedFrames {
    path: PathBuf,
    reader: Reader<BufReader<File>>,
    channels: usize,
    frames: VecDeque<Frame>,
    parts: VecDeque<Part>,
    /// Whether parts are handed on as they are; else frames are assembled from them.
    in_parts: bool,
    assembler: FrameAssembler,
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
            parts: VecDeque::new(),
            in_parts: false,
            assembler: FrameAssembler::default(),
            last_ns: 0,
        })
    }
}

impl RecordedFrames {
    /// The next part as a reading; `None` if its frame is not complete yet.
    fn take_part(&mut self, part: Part) -> Option<SourceReading> {
        let end = part.first.saturating_add(part.volts.len());
        if part.volts.is_empty() || end > self.channels {
            return Some(skipped("a part of another pad's frame"));
        }
        if !self.in_parts {
            let frame = self.assembler.add(&part, self.channels)?;
            return Some(self.take_frame(frame));
        }
        Some(match self.check(part.t_ns, &part.volts) {
            Ok(()) => SourceReading::Part(part),
            Err(skipped) => skipped,
        })
    }

    fn take_frame(&mut self, frame: Frame) -> SourceReading {
        if frame.volts.len() != self.channels {
            return skipped("a frame of another pad");
        }
        match self.check(frame.t_ns, &frame.volts) {
            Ok(()) => SourceReading::Frame(frame),
            Err(skipped) => skipped,
        }
    }

    /// Checks that time goes on, and that voltages are numbers.
    fn check(&mut self, t_ns: Nanos, volts: &[f32]) -> Result<(), SourceReading> {
        if t_ns < self.last_ns || volts.iter().any(|volt| !volt.is_finite()) {
            return Err(skipped(
                "a frame whose time runs backwards, or with a voltage that is not a number",
            ));
        }
        self.last_ns = t_ns;
        Ok(())
    }
}

impl Source for RecordedFrames {
    fn pace(&self) -> SourcePace {
        SourcePace::ByStamp
    }

    fn read_in_parts(&mut self) {
        self.in_parts = true;
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        loop {
            if let Some(frame) = self.frames.pop_front() {
                return Ok(self.take_frame(frame));
            }
            if let Some(part) = self.parts.pop_front() {
                match self.take_part(part) {
                    Some(reading) => return Ok(reading),
                    None => continue,
                }
            }
            match self.reader.next() {
                Ok(Some(Message::Frames(frames))) => self.frames = frames.into(),
                Ok(Some(Message::Parts(parts))) => self.parts = parts.into(),
                Ok(Some(Message::Control(control))) => return Ok(SourceReading::Control(control)),
                Ok(Some(_)) => {}
                // The file is truncated: everything before was played.
                Ok(None) | Err(ReadError::Cut { .. }) => return Ok(SourceReading::End),
                Err(error) => return Err(recording_error(&self.path, error)),
            }
        }
    }
}

fn skipped(why: &str) -> SourceReading {
    SourceReading::Skipped {
        frames: 1,
        reason: why.to_owned(),
    }
}

fn recording_error(path: &Path, error: ReadError) -> SourceError {
    SourceError::Recording {
        path: path.to_owned(),
        error,
    }
}
