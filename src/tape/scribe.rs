//! Writes a session down, step by step: an input, the events and the touches that came of it.

use std::io::{Seek, Write};

use super::message_of;
use crate::engine::Input;
use crate::session::{Gap, Message, Setup, Touches, WriteError, Writer};
use crate::types::{Event, Touch};

/// A session that is being written down.
pub struct Scribe<W: Write + Seek> {
    writer: Writer<W>,
    had_touches: bool,
}

impl<W: Write + Seek> Scribe<W> {
    /// Begins a recording that is handed to the system step by step.
    ///
    /// # Errors
    /// What the system says: no space, no such folder.
    pub fn live(file: W, setup: &Setup) -> Result<Self, WriteError> {
        Ok(Self {
            writer: Writer::live(file, setup)?,
            had_touches: false,
        })
    }

    /// Begins a packed recording.
    ///
    /// # Errors
    /// As [`Self::live`].
    pub fn packed(file: W, setup: &Setup) -> Result<Self, WriteError> {
        Ok(Self {
            writer: Writer::packed(file, setup)?,
            had_touches: false,
        })
    }

    /// Writes what the engine took, the touches that are down after it, and the events that came of it.
    ///
    /// # Errors
    /// What the system says. Nothing should be written after that.
    pub fn step(
        &mut self,
        input: &Input,
        touches: &[Touch],
        events: &[Event],
    ) -> Result<(), WriteError> {
        match (message_of(input), input) {
            (Some(message), _) => self.writer.write(&message)?,
            (None, Input::Matrix(sensing)) => self.writer.matrix(&sensing.to_bytes())?,
            (None, _) => {}
        }
        for event in events {
            self.writer.write(&Message::Event(*event))?;
        }
        if let Input::Frame(frame) = input {
            if self.had_touches || !touches.is_empty() {
                let seen = Touches::of(frame.t_ns, touches);
                self.writer.write(&Message::Touches(seen))?;
            }
            self.had_touches = !touches.is_empty();
        }
        Ok(())
    }

    /// Says that so many inputs are missing here.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn gap(&mut self, inputs: u64) -> Result<(), WriteError> {
        self.writer.write(&Message::Gap(Gap { inputs }))
    }

    /// See [`Writer::flush`].
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn flush(&mut self) -> Result<(), WriteError> {
        self.writer.flush()
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn finish(self) -> Result<W, WriteError> {
        self.writer.finish()
    }
}
