//! Records a session, step by step: an input, its events and its touches.

use std::io::{Seek, Write};

use super::input::message_from_input;
use crate::engine::Input;
use crate::session::{Gap, Message, Setup, Touches, WriteError, Writer};
use crate::types::{Event, Touch};

/// Decides after which inputs touches are recorded: after each frame while there are any, and once when the last has lifted;
/// after a part of a frame only if it has changed them.
#[derive(Clone, Debug, Default)]
pub struct RecordedTouches {
    had_touches: bool,
    /// Check sum of the last ones.
    last_sum: u32,
}

impl RecordedTouches {
    /// The touches to record after an input.
    pub fn after(&mut self, input: &Input, down: &[Touch]) -> Option<Touches> {
        let (t_ns, is_part) = match input {
            Input::Frame(frame) => (frame.t_ns, false),
            Input::Part(part) => (part.t_ns, true),
            _ => return None,
        };
        let had_touches = std::mem::replace(&mut self.had_touches, !down.is_empty());
        if down.is_empty() && !had_touches {
            return None;
        }
        let recorded = Touches::from_touches(t_ns, down);
        let has_changed = std::mem::replace(&mut self.last_sum, recorded.sum) != recorded.sum;
        (has_changed || !is_part).then_some(recorded)
    }
}

/// Records a session.
pub struct SessionWriter<W: Write + Seek> {
    writer: Writer<W>,
    recorded_touches: RecordedTouches,
}

impl<W: Write + Seek> SessionWriter<W> {
    /// Starts a live recording, see [`Writer::live`].
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn live(file: W, setup: &Setup) -> Result<Self, WriteError> {
        Ok(Self {
            writer: Writer::live(file, setup)?,
            recorded_touches: RecordedTouches::default(),
        })
    }

    /// Starts a packed recording, see [`Writer::packed`].
    ///
    /// # Errors
    /// As [`Self::live`].
    pub fn packed(file: W, setup: &Setup) -> Result<Self, WriteError> {
        Ok(Self {
            writer: Writer::packed(file, setup)?,
            recorded_touches: RecordedTouches::default(),
        })
    }

    /// Writes an input, the events that it caused, and the touches that are down after it.
    ///
    /// # Errors
    /// The file cannot be written; the recording ends there.
    pub fn write_step(
        &mut self,
        input: &Input,
        touches: &[Touch],
        events: &[Event],
    ) -> Result<(), WriteError> {
        match (message_from_input(input), input) {
            (Some(message), _) => self.writer.write(&message)?,
            (None, Input::Matrix(sensing)) => self.writer.write_matrix(&sensing.to_bytes())?,
            (None, _) => {}
        }
        for event in events {
            self.writer.write(&Message::Event(*event))?;
        }
        if let Some(recorded) = self.recorded_touches.after(input, touches) {
            self.writer.write(&Message::Touches(recorded))?;
        }
        Ok(())
    }

    /// Notes that this many inputs are missing here; 0 if unknown.
    ///
    /// # Errors
    /// As [`Self::write_step`].
    pub fn write_gap(&mut self, inputs: u64) -> Result<(), WriteError> {
        self.writer.write(&Message::Gap(Gap { inputs }))
    }

    /// See [`Writer::flush`].
    ///
    /// # Errors
    /// As [`Self::write_step`].
    pub fn flush(&mut self) -> Result<(), WriteError> {
        self.writer.flush()
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// As [`Self::write_step`].
    pub fn finish(self) -> Result<W, WriteError> {
        self.writer.finish()
    }
}
