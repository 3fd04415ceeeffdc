//! Records a session, step by step: an input, its events and its touches.

use std::io::{Seek, Write};

use super::input::message_from_input;
use crate::engine::Input;
use crate::session::{Gap, Message, Setup, Touches, WriteError, Writer};
use crate::types::{Event, Touch};

/// Records a session.
pub struct SessionWriter<W: Write + Seek> {
    writer: Writer<W>,
    had_touches: bool,
}

impl<W: Write + Seek> SessionWriter<W> {
    /// Starts a live recording, see [`Writer::live`].
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn live(file: W, setup: &Setup) -> Result<Self, WriteError> {
        Ok(Self {
            writer: Writer::live(file, setup)?,
            had_touches: false,
        })
    }

    /// Starts a packed recording, see [`Writer::packed`].
    ///
    /// # Errors
    /// As [`Self::live`].
    pub fn packed(file: W, setup: &Setup) -> Result<Self, WriteError> {
        Ok(Self {
            writer: Writer::packed(file, setup)?,
            had_touches: false,
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
        if let Input::Frame(frame) = input {
            if self.had_touches || !touches.is_empty() {
                let recorded = Touches::from_touches(frame.t_ns, touches);
                self.writer.write(&Message::Touches(recorded))?;
            }
            self.had_touches = !touches.is_empty();
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
