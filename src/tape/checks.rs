//! What an input of a recording must satisfy: no engine took a frame of another pad, or a time that runs backwards.

use std::sync::Arc;

use super::error::{PlayerError, invalid};
use super::input::texts_from_message;
use crate::eit::ResponseTable;
use crate::pad::Pad;
use crate::profile::Profile;
use crate::session::{Message, ProfileTexts};
use crate::touch::Sensing;
use crate::types::{Frame, Nanos, Part};

/// Longest time between two inputs while outputs may be held, ns: an hour. A damaged time must not make a key repeat for years.
const LONGEST_GAP_NS: Nanos = 3_600_000_000_000;

/// Checks the inputs of a recording in their order.
pub(super) struct InputChecks {
    channels: usize,
    pad: Pad,
    table: Option<Arc<ResponseTable>>,
    last_frame_ns: Nanos,
    /// The latest time so far, while outputs may be held.
    latest_ns: Option<Nanos>,
}

impl InputChecks {
    pub(super) fn new(pad: &Pad, table: Option<&Arc<ResponseTable>>) -> Self {
        Self {
            channels: pad.channels(),
            pad: pad.clone(),
            table: table.cloned(),
            last_frame_ns: 0,
            latest_ns: None,
        }
    }

    /// Checks a frame.
    pub(super) fn frame(&mut self, frame: &Frame) -> Result<(), PlayerError> {
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
        self.time(Some(frame.t_ns), false)?;
        self.last_frame_ns = frame.t_ns;
        Ok(())
    }

    /// Checks a part of a frame.
    pub(super) fn part(&mut self, part: &Part) -> Result<(), PlayerError> {
        let end = part.first.saturating_add(part.volts.len());
        if part.volts.is_empty() || end > self.channels {
            return Err(invalid(format!(
                "a part up to channel {end}, but the pad has {}",
                self.channels
            )));
        }
        if part.t_ns < self.last_frame_ns || part.volts.iter().any(|volt| !volt.is_finite()) {
            return Err(invalid(
                "a part whose time runs backwards, or whose voltages are not finite".to_owned(),
            ));
        }
        self.time(Some(part.t_ns), false)?;
        self.last_frame_ns = part.t_ns;
        Ok(())
    }

    /// Reads a matrix.
    pub(super) fn matrix(&self, bytes: &[u8]) -> Result<Arc<Sensing>, PlayerError> {
        let sensing = Sensing::from_bytes(bytes, self.table.as_ref(), &self.pad)
            .map_err(|error| invalid(error.to_string()))?;
        if sensing.channels() == self.channels {
            Ok(Arc::new(sensing))
        } else {
            Err(invalid("a matrix made for another pad".to_owned()))
        }
    }

    /// Reads a profile.
    pub(super) fn profile(texts: &ProfileTexts) -> Result<Arc<Profile>, PlayerError> {
        let checked = texts_from_message(texts).read().map_err(|faulty| {
            let fault = faulty
                .diagnostics
                .first()
                .map(|fault| fault.message.clone());
            invalid(format!("a profile: {}", fault.unwrap_or_default()))
        })?;
        Ok(Arc::new(checked.profile))
    }

    /// Refuses an implausibly long time between two inputs.
    pub(super) fn time(&mut self, t_ns: Option<Nanos>, ends: bool) -> Result<(), PlayerError> {
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

    /// Checks a message as it will be played; `matrix` are the bytes that a matrix message names.
    pub(super) fn message(
        &mut self,
        message: &Message,
        matrix: Option<&[u8]>,
    ) -> Result<(), PlayerError> {
        match message {
            Message::Frames(frames) => return frames.iter().try_for_each(|one| self.frame(one)),
            Message::Parts(parts) => return parts.iter().try_for_each(|one| self.part(one)),
            Message::Profile(texts) => drop(Self::profile(texts)?),
            Message::Matrix(_) => drop(matrix.map(|bytes| self.matrix(bytes)).transpose()?),
            Message::Touches(_) | Message::TouchBlock(_) | Message::Event(_) => return Ok(()),
            _ => {}
        }
        self.time(message.t_ns(), matches!(message, Message::End(_)))
    }
}
