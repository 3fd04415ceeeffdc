//! Plays a recording: one input, event or list of touches at a time.

use std::collections::VecDeque;
use std::io::{Read, Seek};
use std::sync::Arc;

use super::engine_config::{EngineConfig, EngineConfigError};
use super::input::texts_from_message;
use crate::eit::ResponseTable;
use crate::engine::Input;
use crate::pad::Pad;
use crate::session::{Message, ReadError, Reader, Touches};
use crate::touch::Sensing;
use crate::types::{Event, Frame, Nanos};

/// Longest time between two inputs while outputs may be held, ns: an hour. A damaged time must not make a key repeat for years.
const LONGEST_GAP_NS: Nanos = 3_600_000_000_000;

/// The next item of a recording.
#[derive(Clone, Debug)]
pub enum RecordedItem {
    /// An input of the engine.
    Input(Input),
    /// The touches of the last frame.
    Touches(Touches),
    /// An event of the last input.
    Event(Event),
    /// The recorder dropped inputs here.
    Gap {
        /// Number of inputs; 0 if unknown.
        inputs: u64,
    },
}

/// Plays a recording.
pub struct RecordingPlayer<R> {
    reader: Reader<R>,
    frames: VecDeque<Frame>,
    channels: usize,
    pad: Pad,
    table: Option<Arc<ResponseTable>>,
    last_frame_ns: Nanos,
    /// The latest time so far, while outputs may be held.
    latest_ns: Option<Nanos>,
}

impl<R: Read + Seek> RecordingPlayer<R> {
    /// Opens a recording and reads the configuration of its engine.
    ///
    /// # Errors
    /// See [`Reader::open`] and [`EngineConfig::from_setup`].
    pub fn open(file: R) -> Result<(Self, EngineConfig), PlayerError> {
        let (reader, setup) = Reader::open(file)?;
        let config = EngineConfig::from_setup(&setup)?;
        let player = Self {
            reader,
            frames: VecDeque::new(),
            channels: config.pad.channels(),
            pad: config.pad.clone(),
            table: config.table.clone(),
            last_frame_ns: 0,
            latest_ns: None,
        };
        Ok((player, config))
    }

    /// The next item; `None` at the end.
    ///
    /// # Errors
    /// See [`Reader::next`]; inputs that no engine can have taken.
    #[allow(clippy::should_implement_trait, reason = "an error ends it")]
    pub fn next(&mut self) -> Result<Option<RecordedItem>, PlayerError> {
        if let Some(frame) = self.frames.pop_front() {
            return self.check_frame(frame).map(Some);
        }
        let Some(message) = self.reader.next()? else {
            return Ok(None);
        };
        let input = match message {
            Message::Frames(frames) => {
                self.frames = frames.into();
                return self.next();
            }
            Message::Control(control) => Input::Control(control),
            Message::Tick(at) => Input::Tick { due_ns: at.t_ns },
            Message::Profile(texts) => {
                let checked = texts_from_message(&texts).read().map_err(|faulty| {
                    let fault = faulty
                        .diagnostics
                        .first()
                        .map(|fault| fault.message.clone());
                    invalid(format!("a profile: {}", fault.unwrap_or_default()))
                })?;
                Input::Profile {
                    t_ns: texts.t_ns,
                    profile: Arc::new(checked.profile),
                }
            }
            Message::Pause(at) => Input::Pause { t_ns: at.t_ns },
            Message::Matrix(name) => Input::Matrix(self.read_matrix(&name.attachment)?),
            Message::Rezero(at) => Input::Rezero { t_ns: at.t_ns },
            Message::Lost(lost) => Input::Lost {
                frames: lost.frames,
            },
            Message::End(at) => Input::End { t_ns: at.t_ns },
            Message::Gap(gap) => return Ok(Some(RecordedItem::Gap { inputs: gap.inputs })),
            Message::Touches(touches) => return Ok(Some(RecordedItem::Touches(touches))),
            Message::Event(event) => return Ok(Some(RecordedItem::Event(event))),
        };
        self.check_gap(time_of(&input), matches!(input, Input::End { .. }))?;
        Ok(Some(RecordedItem::Input(input)))
    }

    /// Whether the file was closed properly; known at its end.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.reader.is_whole()
    }

    fn check_frame(&mut self, frame: Frame) -> Result<RecordedItem, PlayerError> {
        if frame.volts.len() != self.channels {
            let (has, wants) = (frame.volts.len(), self.channels);
            return Err(invalid(format!(
                "a frame of {has} voltages, but the pad has {wants}"
            )));
        }
        if frame.t_ns < self.last_frame_ns || frame.volts.iter().any(|volt| !volt.is_finite()) {
            return Err(invalid(
                "a frame whose time runs backwards, or whose voltages are not finite".to_owned(),
            ));
        }
        self.last_frame_ns = frame.t_ns;
        self.check_gap(Some(frame.t_ns), false)?;
        Ok(RecordedItem::Input(Input::Frame(frame)))
    }

    fn read_matrix(&self, name: &str) -> Result<Arc<Sensing>, PlayerError> {
        let bytes = self
            .reader
            .attachment(name)
            .ok_or_else(|| invalid(format!("the matrix {name} is missing")))?;
        let sensing = Sensing::from_bytes(bytes, self.table.as_ref(), &self.pad)
            .map_err(|error| invalid(error.to_string()))?;
        if sensing.channels() == self.channels {
            Ok(Arc::new(sensing))
        } else {
            Err(invalid("a matrix made for another pad".to_owned()))
        }
    }

    /// Refuses an implausibly long time between two inputs.
    fn check_gap(&mut self, t_ns: Option<Nanos>, ends: bool) -> Result<(), PlayerError> {
        let Some(t_ns) = t_ns else {
            return Ok(());
        };
        let late = |since: Nanos| t_ns > since + LONGEST_GAP_NS;
        if !ends && self.latest_ns.is_some_and(late) {
            return Err(invalid(
                "a time more than an hour after the previous one".to_owned(),
            ));
        }
        self.latest_ns = if ends {
            None
        } else {
            Some(self.latest_ns.unwrap_or(0).max(t_ns))
        };
        Ok(())
    }
}

/// Why a recording cannot be played, or not beyond some point.
#[derive(Debug, thiserror::Error)]
pub enum PlayerError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// No engine can be built from its attachments.
    #[error(transparent)]
    EngineConfig(#[from] EngineConfigError),
    /// It contains an input that no engine can have taken.
    #[error("the recording contains an invalid input: {0}")]
    Invalid(String),
}

fn invalid(what: String) -> PlayerError {
    PlayerError::Invalid(what)
}

/// The time of an input, where it has one.
fn time_of(input: &Input) -> Option<Nanos> {
    match input {
        Input::Frame(frame) => Some(frame.t_ns),
        Input::Control(control) => Some(control.t_ns),
        Input::Tick { due_ns: t_ns }
        | Input::Profile { t_ns, .. }
        | Input::Pause { t_ns }
        | Input::Rezero { t_ns }
        | Input::End { t_ns } => Some(*t_ns),
        Input::Matrix(_) | Input::Lost { .. } => None,
    }
}
