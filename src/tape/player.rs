//! Plays a recording: one input, event or list of touches at a time.

use std::collections::VecDeque;
use std::io::{Read, Seek};
use std::sync::Arc;

use super::checks::InputChecks;
use super::engine_config::EngineConfig;
use super::error::{PlayerError, invalid};
use crate::engine::Input;
use crate::session::{Message, Reader, Setup, Touches};
use crate::touch::Sensing;
use crate::types::{Event, Frame, Nanos, Part};

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
    parts: VecDeque<Part>,
    touches: VecDeque<Touches>,
    checks: InputChecks,
}

impl<R: Read + Seek> RecordingPlayer<R> {
    /// Opens a recording and reads the configuration of its engine.
    ///
    /// # Errors
    /// See [`Reader::open`] and [`EngineConfig::from_setup`].
    pub fn open(file: R) -> Result<(Self, EngineConfig), PlayerError> {
        Self::open_with(file, |setup| setup)
    }

    /// The same; `complete` adds what a slim recording only names.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_with(
        file: R,
        complete: impl FnOnce(Setup) -> Setup,
    ) -> Result<(Self, EngineConfig), PlayerError> {
        let (reader, setup) = Reader::open(file)?;
        let setup = complete(setup);
        let config = EngineConfig::from_setup(&setup)?;
        let player = Self {
            reader,
            frames: VecDeque::new(),
            parts: VecDeque::new(),
            touches: VecDeque::new(),
            checks: InputChecks::new(&config.pad, config.table.as_ref()),
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
        if let Some(part) = self.parts.pop_front() {
            self.checks.part(&part)?;
            return Ok(Some(RecordedItem::Input(Input::Part(part))));
        }
        if let Some(touches) = self.touches.pop_front() {
            return Ok(Some(RecordedItem::Touches(touches)));
        }
        let Some(message) = self.reader.next()? else {
            return Ok(None);
        };
        let input = match message {
            Message::Frames(frames) => {
                self.frames = frames.into();
                return self.next();
            }
            Message::Parts(parts) => {
                self.parts = parts.into();
                return self.next();
            }
            Message::Control(control) => Input::Control(control),
            Message::Tick(at) => Input::Tick { due_ns: at.t_ns },
            Message::Profile(texts) => Input::Profile {
                t_ns: texts.t_ns,
                profile: InputChecks::profile(&texts)?,
            },
            Message::Pause(at) => Input::Pause { t_ns: at.t_ns },
            Message::Matrix(name) => Input::Matrix(self.read_matrix(&name.attachment)?),
            Message::Rezero(at) => Input::Rezero { t_ns: at.t_ns },
            Message::Lost(lost) => Input::Lost {
                frames: lost.frames,
            },
            Message::End(at) => Input::End { t_ns: at.t_ns },
            Message::Gap(gap) => return Ok(Some(RecordedItem::Gap { inputs: gap.inputs })),
            Message::Touches(touches) => return Ok(Some(RecordedItem::Touches(touches))),
            Message::TouchBlock(block) => {
                self.touches = block.frames.into();
                return self.next();
            }
            Message::Event(event) => return Ok(Some(RecordedItem::Event(event))),
        };
        self.checks
            .time(time_of(&input), matches!(input, Input::End { .. }))?;
        Ok(Some(RecordedItem::Input(input)))
    }

    /// Whether the file was closed properly; known at its end.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.reader.is_whole()
    }

    fn check_frame(&mut self, frame: Frame) -> Result<RecordedItem, PlayerError> {
        self.checks.frame(&frame)?;
        Ok(RecordedItem::Input(Input::Frame(frame)))
    }

    fn read_matrix(&self, name: &str) -> Result<Arc<Sensing>, PlayerError> {
        let bytes = self
            .reader
            .attachment(name)
            .ok_or_else(|| invalid(format!("the matrix {name} is missing")))?;
        self.checks.matrix(bytes)
    }
}

/// The time of an input, where it has one.
fn time_of(input: &Input) -> Option<Nanos> {
    match input {
        Input::Frame(frame) => Some(frame.t_ns),
        Input::Part(part) => Some(part.t_ns),
        Input::Control(control) => Some(control.t_ns),
        Input::Tick { due_ns: t_ns }
        | Input::Profile { t_ns, .. }
        | Input::Pause { t_ns }
        | Input::Rezero { t_ns }
        | Input::End { t_ns } => Some(*t_ns),
        Input::Matrix(_) | Input::Lost { .. } => None,
    }
}
