//! A recording, input by input.

use std::collections::VecDeque;
use std::io::{Read, Seek};
use std::sync::Arc;

use super::input::read_texts;
use super::{Kit, KitError};
use crate::eit::ResponseTable;
use crate::engine::Input;
use crate::pad::Outline;
use crate::session::{Message, ReadError, Reader, Touches};
use crate::touch::Sensing;
use crate::types::{Event, Frame, Nanos};

/// While something may be held no input comes so long after the one before, ns: an hour. A damaged time must not make a key
/// repeat for years.
const LONGEST_WAIT_NS: Nanos = 3_600_000_000_000;

/// What a recording has next.
#[derive(Clone, Debug)]
pub enum Played {
    /// An input of the engine.
    Input(Input),
    /// The touches that came of the last frame.
    Touches(Touches),
    /// An event that came of the last input.
    Event(Event),
    /// Here the recorder left out so many inputs (0: nobody knows how many).
    Gap {
        /// How many.
        inputs: u64,
    },
}

/// Plays a recording.
pub struct Player<R> {
    reader: Reader<R>,
    frames: VecDeque<Frame>,
    channels: usize,
    outline: Outline,
    table: Option<Arc<ResponseTable>>,
    last_frame_ns: Nanos,
    /// The latest time so far, while something may be held.
    waits_since_ns: Option<Nanos>,
}

impl<R: Read + Seek> Player<R> {
    /// Opens a recording and makes what its engine is made of.
    ///
    /// # Errors
    /// See [`Reader::open`]; attachments that make no engine.
    pub fn open(file: R) -> Result<(Self, Kit), PlayerError> {
        let (reader, setup) = Reader::open(file)?;
        let kit = Kit::of_setup(&setup)?;
        let player = Self {
            reader,
            frames: VecDeque::new(),
            channels: kit.pad.channels(),
            outline: kit.pad.outline,
            table: kit.table.clone(),
            last_frame_ns: 0,
            waits_since_ns: None,
        };
        Ok((player, kit))
    }

    /// What comes next; none at the end.
    ///
    /// # Errors
    /// See [`Reader::next`]; inputs that no engine was ever given.
    #[allow(clippy::should_implement_trait, reason = "it may fail for good")]
    pub fn next(&mut self) -> Result<Option<Played>, PlayerError> {
        if let Some(frame) = self.frames.pop_front() {
            return self.frame(frame).map(Some);
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
                let checked = read_texts(&texts).read().map_err(|faulty| {
                    let fault = faulty.faults.first().map(|fault| fault.message.clone());
                    strange(format!("a profile: {}", fault.unwrap_or_default()))
                })?;
                Input::Profile {
                    t_ns: texts.t_ns,
                    profile: Arc::new(checked.profile),
                }
            }
            Message::Pause(at) => Input::Pause { t_ns: at.t_ns },
            Message::Matrix(name) => Input::Matrix(self.matrix(&name.attachment)?),
            Message::Rezero(at) => Input::Rezero { t_ns: at.t_ns },
            Message::Lost(lost) => Input::Lost {
                frames: lost.frames,
            },
            Message::End(at) => Input::End { t_ns: at.t_ns },
            Message::Gap(gap) => return Ok(Some(Played::Gap { inputs: gap.inputs })),
            Message::Touches(touches) => return Ok(Some(Played::Touches(touches))),
            Message::Event(event) => return Ok(Some(Played::Event(event))),
        };
        self.watch(time_of(&input), matches!(input, Input::End { .. }))?;
        Ok(Some(Played::Input(input)))
    }

    /// Whether the file was closed as it should be: known at its end.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.reader.is_whole()
    }

    fn frame(&mut self, frame: Frame) -> Result<Played, PlayerError> {
        if frame.volts.len() != self.channels {
            let (has, wants) = (frame.volts.len(), self.channels);
            return Err(strange(format!(
                "a frame of {has} voltages, where the pad has {wants}"
            )));
        }
        if frame.t_ns < self.last_frame_ns || frame.volts.iter().any(|volt| !volt.is_finite()) {
            return Err(strange(
                "a frame that no source gives: its time runs backwards, or a voltage is no number"
                    .to_owned(),
            ));
        }
        self.last_frame_ns = frame.t_ns;
        self.watch(Some(frame.t_ns), false)?;
        Ok(Played::Input(Input::Frame(frame)))
    }

    fn matrix(&self, name: &str) -> Result<Arc<Sensing>, PlayerError> {
        let bytes = self
            .reader
            .attachment(name)
            .ok_or_else(|| strange(format!("the matrix {name} is missing")))?;
        let sensing = Sensing::from_bytes(bytes, self.table.as_ref(), &self.outline)
            .map_err(|error| strange(error.to_string()))?;
        if sensing.channels() == self.channels {
            Ok(Arc::new(sensing))
        } else {
            Err(strange("a matrix of another pad".to_owned()))
        }
    }

    fn watch(&mut self, t_ns: Option<Nanos>, ends: bool) -> Result<(), PlayerError> {
        let Some(t_ns) = t_ns else {
            return Ok(());
        };
        let late = |since: Nanos| t_ns > since + LONGEST_WAIT_NS;
        if !ends && self.waits_since_ns.is_some_and(late) {
            return Err(strange(
                "a time more than an hour after the one before".to_owned(),
            ));
        }
        self.waits_since_ns = if ends {
            None
        } else {
            Some(self.waits_since_ns.unwrap_or(0).max(t_ns))
        };
        Ok(())
    }
}

/// Why a recording cannot be played, or not further.
#[derive(Debug, thiserror::Error)]
pub enum PlayerError {
    /// It cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// Its attachments make no engine.
    #[error(transparent)]
    Kit(#[from] KitError),
    /// It holds what no engine was ever given.
    #[error("the recording holds what no engine was given: {0}")]
    Strange(String),
}

fn strange(what: String) -> PlayerError {
    PlayerError::Strange(what)
}

/// When an input is, if it says so.
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
