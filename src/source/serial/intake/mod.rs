//! Turns bytes into frames of the pad: dialect, number of values, order, losses, time. It does no IO.
//!
//! Frames are accepted after [`SURE_FRAMES`] frames in a row had the same plausible number of values: a line
//! that was cut must not pass for a frame of another layout. Their median tells the order. Afterwards a frame
//! with another number of values is garbled, until the board has changed to that number for good.

mod parts;
#[cfg(test)]
mod parts_tests;
mod start;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::sync::Arc;

use super::sequence::{Place, Sequence};
use crate::pad::{Channel, Pad};
use crate::source::arrangement::{Arrangement, plausible_counts};
use crate::source::clock::DeviceClock;
use crate::source::leading::leading_columns;
use crate::source::wire::{Decoded, Dialect, FormatChoice, WireFrame, Wiring};
use crate::source::{SourceError, SourceReading};
use crate::types::{Frame, Nanos, Part};
use parts::PartIntake;
use start::Start;

/// Number of frames with the same number of values that are needed to be sure.
const SURE_FRAMES: usize = 3;

/// Converts what a board sends into frames of a pad.
pub(super) struct FrameIntake {
    pad: Pad,
    format: FormatChoice,
    dialect: Box<dyn Dialect>,
    counts: Vec<usize>,
    arrangement: Option<Arrangement>,
    /// The board's own list of channels when the arrangement was found.
    listing: Option<Arc<[Channel]>>,
    /// Frames with a number of values that is not sure yet, and their arrival.
    unsure: Vec<(WireFrame, Nanos)>,
    clock: DeviceClock,
    sequence: Sequence,
    /// Hands on frames that are still arriving.
    parts: PartIntake,
    last_ns: Nanos,
    /// Columns before the readings, which are ignored.
    leading: usize,
    /// What has arrived before the first frame since the port was opened; none afterwards.
    start: Option<Start>,
    /// Whether waiting for that frame has an end.
    requires_frames: bool,
    decoded: Vec<Decoded>,
}

impl FrameIntake {
    pub(super) fn new(pad: &Pad, format: FormatChoice) -> Self {
        Self {
            dialect: format.dialect(&Wiring::from_pad(pad)),
            counts: plausible_counts(pad),
            pad: pad.clone(),
            format,
            arrangement: None,
            listing: None,
            unsure: Vec::new(),
            clock: DeviceClock::default(),
            sequence: Sequence::default(),
            parts: PartIntake::default(),
            last_ns: 0,
            leading: 0,
            start: Some(Start::default()),
            requires_frames: false,
            decoded: Vec::new(),
        }
    }

    /// From now on frames are handed on in parts while they arrive, if that takes long.
    pub(super) fn hand_on_parts(&mut self) {
        if !self.format.whole {
            self.parts.switch_on();
            self.dialect.hand_up_readings();
        }
    }

    /// From now on a board that sends something for long, but no frame, is an error.
    pub(super) fn require_frames(&mut self) {
        self.requires_frames = true;
    }

    /// Readings of the pad.
    pub(super) fn channels(&self) -> usize {
        self.pad.channels()
    }

    /// Drops the frames that wait for others of the same number of values; returns how many.
    pub(super) fn drop_unsure(&mut self) -> usize {
        self.unsure.drain(..).count()
    }

    /// Takes bytes that arrived at `now_ns`, a time that continues while the board is away; `opened_ns` is
    /// when the port was last opened.
    ///
    /// # Errors
    /// The board measures with another protocol than the pad's; it sends no frame, but is required to.
    pub(super) fn feed(
        &mut self,
        now_ns: Nanos,
        opened_ns: Nanos,
        bytes: &[u8],
        readings: &mut VecDeque<SourceReading>,
    ) -> Result<(), SourceError> {
        let mut decoded = std::mem::take(&mut self.decoded);
        let before = readings.len();
        let mut are_stamped = false;
        self.dialect
            .feed(now_ns.saturating_sub(opened_ns), bytes, &mut decoded);
        for one in decoded.drain(..) {
            match one {
                Decoded::Frame(frame) => {
                    are_stamped |= frame.stamp.is_some();
                    self.frame(frame, now_ns, readings)?;
                }
                Decoded::Readings(part) => {
                    are_stamped |= part.stamp.is_some();
                    if let Some(arrangement) = &self.arrangement {
                        let context = (arrangement, &mut self.clock);
                        self.parts
                            .take_readings(part, self.leading, now_ns, context, readings);
                    }
                }
                Decoded::Garbled { reason, .. } => match &mut self.start {
                    Some(start) => start.garbled(reason),
                    None => {
                        // If the board counts frames, the next number tells how many were lost.
                        let frames = u64::from(!self.sequence.is_counted());
                        if frames > 0 {
                            self.parts.abandon();
                        }
                        readings.push_back(SourceReading::Skipped { reason, frames });
                    }
                },
                Decoded::Note(text) => tracing::info!(target: "gelpad::told", "{text}"),
            }
        }
        self.decoded = decoded;
        if !are_stamped {
            self.spread_times(readings.range_mut(before..));
        }
        match &mut self.start {
            // Frames of another pad are reported one by one.
            Some(start) if readings.len() == before => {
                start.take(bytes.len(), now_ns, self.requires_frames)
            }
            _ => Ok(()),
        }
    }

    /// Spreads the times of parts that arrived together.
    fn spread_times<'a>(&mut self, fresh: impl Iterator<Item = &'a mut SourceReading>) {
        let mut parts: Vec<&mut Part> = fresh
            .filter_map(|reading| match reading {
                SourceReading::Part(part) => Some(part),
                _ => None,
            })
            .collect();
        self.parts.spread_times(self.last_ns, &mut parts);
        if let Some(last) = parts.last() {
            self.last_ns = last.t_ns;
        }
    }

    /// A command that the board needs now.
    pub(super) fn poll_command(&mut self, now_ns: Nanos, opened_ns: Nanos) -> Option<Vec<u8>> {
        self.dialect.poll_command(now_ns.saturating_sub(opened_ns))
    }

    pub(super) fn stop_command(&self) -> &'static [u8] {
        self.dialect.stop_command()
    }

    /// The board is back: incomplete frames are dropped, the order is kept.
    pub(super) fn reopened(&mut self) {
        self.dialect.reopened();
        self.clock.reset();
        self.unsure.clear();
        self.sequence = Sequence::default();
        self.parts.reset();
        self.start = Some(Start::default());
    }

    fn frame(
        &mut self,
        mut frame: WireFrame,
        now_ns: Nanos,
        readings: &mut VecDeque<SourceReading>,
    ) -> Result<(), SourceError> {
        if self.leading > 0 && frame.values.len() > self.leading {
            frame.values.drain(..self.leading);
        }
        let count = frame.values.len();
        self.take_listing(&frame);
        if let Some(arrangement) = &self.arrangement
            && arrangement.values() == count
            && self.listing == frame.listing
        {
            let volts = arrangement.apply(&frame.values);
            self.unsure.clear();
            self.deliver(&frame, now_ns, volts, readings);
            return Ok(());
        }
        self.parts.abandon();
        if !self.counts.contains(&count) && !self.may_have_leading(count) {
            self.report_count(count, readings);
            return Ok(());
        }
        if self
            .unsure
            .last()
            .is_some_and(|(last, _)| last.values.len() != count)
        {
            self.unsure.clear();
        }
        if self.arrangement.is_some() {
            self.report_count(count, readings);
        }
        self.unsure.push((frame, now_ns));
        if self.unsure.len() < SURE_FRAMES {
            return Ok(());
        }
        if !self.counts.contains(&count) && !self.drop_leading(readings) {
            return Ok(());
        }
        self.find_arrangement(readings)
    }

    /// Whether frames with this number of values may have columns before the readings.
    fn may_have_leading(&self, count: usize) -> bool {
        let plausible = |columns| self.counts.contains(&(count.saturating_sub(columns)));
        self.arrangement.is_none() && self.leading == 0 && (1..=3).any(plausible)
    }

    /// Removes the columns before the readings from the frames that are not sure yet; returns whether there are any.
    fn drop_leading(&mut self, readings: &mut VecDeque<SourceReading>) -> bool {
        let frames = self.unsure.iter().map(|(frame, _)| frame.values.as_slice());
        let Some(columns) = leading_columns(frames, |count| self.counts.contains(&count)) else {
            let (first, _) = self.unsure.remove(0);
            self.report_count(first.values.len(), readings);
            return false;
        };
        let noun = if columns == 1 { "column" } else { "columns" };
        tracing::info!(
            target: "gelpad::told",
            "{columns} {noun} before the readings ignored: a counter or a time"
        );
        self.leading = columns;
        for (frame, _) in &mut self.unsure {
            frame.values.drain(..columns);
        }
        true
    }

    /// A board whose order was found from its readings names them: from now on its names count.
    fn take_listing(&mut self, frame: &WireFrame) {
        let is_news = self.arrangement.is_some() && self.listing.is_none();
        let listing = frame.listing.as_deref().filter(|_| is_news);
        let Some(Ok(named)) =
            listing.map(|listing| Arrangement::find(&frame.values, Some(listing), None, &self.pad))
        else {
            return;
        };
        if self
            .arrangement
            .as_ref()
            .is_some_and(|found| !found.reads_as(&named))
        {
            tracing::info!(target: "gelpad::told", "{}", named.summary());
            self.parts.abandon();
            self.parts.set_arrangement(&named);
            self.arrangement = Some(named);
        }
        self.listing.clone_from(&frame.listing);
    }

    /// Finds the arrangement from the frames that are not sure yet, and delivers them.
    fn find_arrangement(
        &mut self,
        readings: &mut VecDeque<SourceReading>,
    ) -> Result<(), SourceError> {
        let listing = self.unsure[0].0.listing.clone();
        let found = Arrangement::find(
            &self.median(),
            listing.as_deref(),
            self.format.order,
            &self.pad,
        );
        let found = match found {
            Ok(found) => found,
            // Damage may look like another board; the known one is kept.
            Err(_) if self.arrangement.is_some() => {
                self.unsure.clear();
                return Ok(());
            }
            Err(error) => return Err(SourceError::Arrangement(error)),
        };
        tracing::info!(target: "gelpad::told", "{}", found.summary());
        let had_one = self.arrangement.is_some();
        for (frame, arrived_ns) in std::mem::take(&mut self.unsure) {
            let volts = found.apply(&frame.values);
            // Frames that were reported as lost are not played late.
            if !had_one {
                self.deliver(&frame, arrived_ns, volts, readings);
            }
        }
        self.parts.set_arrangement(&found);
        self.arrangement = Some(found);
        self.listing = listing;
        Ok(())
    }

    fn deliver(
        &mut self,
        frame: &WireFrame,
        arrived_ns: Nanos,
        volts: Vec<f32>,
        readings: &mut VecDeque<SourceReading>,
    ) {
        self.start = None;
        match self.sequence.take_number(frame.sequence) {
            Place::New { missing: 0 } => {}
            Place::New { missing } => {
                let are = if missing == 1 {
                    "frame is"
                } else {
                    "frames are"
                };
                readings.push_back(SourceReading::Skipped {
                    reason: format!("{missing} {are} missing according to the board's count"),
                    frames: u64::from(missing),
                });
            }
            Place::Older => {
                self.parts.abandon();
                let number = frame.sequence.unwrap_or(0);
                readings.push_back(SourceReading::Skipped {
                    reason: format!("frame number {number} again, or too late"),
                    frames: 0,
                });
                return;
            }
        }
        let number = (frame.sequence, frame.stamp);
        let clock = &mut self.clock;
        if self
            .parts
            .end_frame(&volts, number, arrived_ns, clock, readings)
        {
            return;
        }
        let t_ns = self.clock.frame_time(frame.stamp, arrived_ns);
        self.last_ns = t_ns;
        readings.push_back(SourceReading::Frame(Frame { t_ns, volts }));
    }

    fn report_count(&self, count: usize, readings: &mut VecDeque<SourceReading>) {
        let wanted = self
            .arrangement
            .as_ref()
            .map_or(self.pad.channels(), Arrangement::values);
        let reason = if count == wanted {
            format!("{count} values, but of other drives than before")
        } else {
            format!("{count} values instead of {wanted}: is this another pad?")
        };
        readings.push_back(SourceReading::Skipped { reason, frames: 1 });
    }

    /// The median of each value, so that a garbled frame does not disturb the order.
    fn median(&self) -> Vec<f32> {
        let count = self
            .unsure
            .first()
            .map_or(0, |(frame, _)| frame.values.len());
        (0..count)
            .map(|index| {
                let mut values: Vec<f32> = self
                    .unsure
                    .iter()
                    .map(|(frame, _)| frame.values[index])
                    .collect();
                values.sort_unstable_by(f32::total_cmp);
                values[values.len() / 2]
            })
            .collect()
    }
}
