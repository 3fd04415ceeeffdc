//! Turns bytes into frames of the pad: dialect, number of values, order, losses, time. It does no IO.
//!
//! Frames are accepted after [`SURE_FRAMES`] frames in a row had the same plausible number of values: a line
//! that was cut must not pass for a frame of another layout. Their median tells the order. Afterwards a frame
//! with another number of values is garbled, until the board has changed to that number for good.

use std::collections::VecDeque;
use std::sync::Arc;

use super::sequence::{Place, Sequence};
use crate::pad::{Channel, Pad};
use crate::source::arrangement::{Arrangement, plausible_counts};
use crate::source::clock::DeviceClock;
use crate::source::leading::leading_columns;
use crate::source::wire::{Decoded, Dialect, FormatChoice, WireFrame, Wiring};
use crate::source::{SourceError, SourceReading};
use crate::types::{Frame, Nanos};

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
    /// Columns before the readings, which are ignored.
    leading: usize,
    /// Whether a frame has arrived since the port was opened: what is garbled before was cut by the opening.
    begun: bool,
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
            leading: 0,
            begun: false,
            decoded: Vec::new(),
        }
    }

    /// Takes bytes that arrived at `now_ns`, a time that continues while the board is away; `opened_ns` is
    /// when the port was last opened.
    ///
    /// # Errors
    /// The board measures with another protocol than the pad's.
    pub(super) fn feed(
        &mut self,
        now_ns: Nanos,
        opened_ns: Nanos,
        bytes: &[u8],
        readings: &mut VecDeque<SourceReading>,
    ) -> Result<(), SourceError> {
        let mut decoded = std::mem::take(&mut self.decoded);
        self.dialect
            .feed(now_ns.saturating_sub(opened_ns), bytes, &mut decoded);
        for one in decoded.drain(..) {
            match one {
                Decoded::Frame(frame) => self.frame(frame, now_ns, readings)?,
                Decoded::Garbled { reason, .. } if self.begun => {
                    // If the board counts frames, the next number tells how many were lost.
                    let frames = u64::from(!self.sequence.is_counted());
                    readings.push_back(SourceReading::Skipped { reason, frames });
                }
                Decoded::Garbled { reason, .. } => {
                    tracing::debug!("before the first frame: {reason}")
                }
                Decoded::Note(text) => tracing::info!(target: "gelpad::told", "{text}"),
            }
        }
        self.decoded = decoded;
        Ok(())
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
        self.begun = false;
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
        if let Some(arrangement) = &self.arrangement
            && arrangement.values() == count
            && self.listing == frame.listing
        {
            let volts = arrangement.apply(&frame.values);
            self.unsure.clear();
            self.deliver(&frame, now_ns, volts, readings);
            return Ok(());
        }
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
        self.begun = true;
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
                let number = frame.sequence.unwrap_or(0);
                readings.push_back(SourceReading::Skipped {
                    reason: format!("frame number {number} again, or too late"),
                    frames: 0,
                });
                return;
            }
        }
        let t_ns = self.clock.frame_time(frame.stamp, arrived_ns);
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
            format!("{count} values instead of {wanted}: is this another pad (--pad)?")
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::shipped_pad;
    use crate::source::SimulatedPad;
    use crate::source::wire::gelpad::{Values, encode};
    use crate::source::wire::{WireFormat, openeit};

    fn pad(name: &str) -> Pad {
        Pad::from_toml(name, shipped_pad(name).expect("shipped").toml).expect("sound")
    }

    fn rest(pad: &Pad) -> Vec<f32> {
        let volts = SimulatedPad::new(pad).and_then(|simulated| simulated.volts(&[]));
        let volts = volts.expect("solved");
        volts.into_iter().map(|volt| 1e3 * volt as f32).collect()
    }

    fn readings_of(intake: &mut FrameIntake, bytes: &[u8]) -> Vec<SourceReading> {
        let mut readings = VecDeque::new();
        intake.feed(5, 0, bytes, &mut readings).expect("fits");
        readings.into()
    }

    fn frames(readings: &[SourceReading]) -> usize {
        let is_frame = |reading: &&SourceReading| matches!(reading, SourceReading::Frame(_));
        readings.iter().filter(is_frame).count()
    }

    fn lost(readings: &[SourceReading]) -> u64 {
        let frames = |reading: &SourceReading| match reading {
            SourceReading::Skipped { frames, .. } => *frames,
            _ => 0,
        };
        readings.iter().map(frames).sum()
    }

    #[test]
    fn losses_are_counted_once_by_the_numbers_of_the_board() {
        let pad = pad("edinburgh-lattice");
        let volts = rest(&pad);
        let mut intake = FrameIntake::new(&pad, WireFormat::Gelpad.into());
        let packet = |n: u32| encode(Values::F32, n, n.wrapping_mul(1000), &volts);
        // The count overflows in between.
        let begin: Vec<u8> = (0..5_u32).flat_map(|n| packet(n.wrapping_sub(2))).collect();
        assert_eq!(frames(&readings_of(&mut intake, &begin)), 5);
        let mut damaged = packet(3);
        damaged[100] ^= 0x55;
        // Number 3 is garbled, 4 and 5 never arrive.
        let readings = readings_of(&mut intake, &[damaged, packet(6)].concat());
        assert_eq!((frames(&readings), lost(&readings)), (1, 3));
        // A board that was reset restarts its count: no frame counts as lost.
        let readings = readings_of(&mut intake, &packet(0));
        assert_eq!((frames(&readings), lost(&readings)), (1, 0));
    }

    #[test]
    fn late_and_repeated_packets_are_dropped_and_counted() {
        let pad = pad("edinburgh-lattice");
        let volts = rest(&pad);
        let mut intake = FrameIntake::new(&pad, WireFormat::Gelpad.into());
        let packet = |n: u32| encode(Values::F32, n, n.wrapping_mul(1000), &volts);
        let numbers = [70, 71, 72, 73, 72, 73, 73, 74];
        let bytes: Vec<u8> = numbers.into_iter().flat_map(packet).collect();
        let readings = readings_of(&mut intake, &bytes);
        assert_eq!((frames(&readings), lost(&readings)), (5, 0));
        let is_skip = |one: &&SourceReading| matches!(one, SourceReading::Skipped { .. });
        assert_eq!(readings.iter().filter(is_skip).count(), 3);
    }

    #[test]
    fn columns_before_the_readings_are_ignored() {
        let pad = pad("edinburgh-lattice");
        let volts = rest(&pad);
        let words: Vec<String> = volts.iter().map(|volt| format!("{volt:.5}")).collect();
        let decimal_commas = words.join("\t").replace('.', ",");
        for (line, case) in [
            (format!("@,{}", words.join(",")), "a counter"),
            (
                format!("@;{:.3};{}", 0.5, words.join(";")),
                "a counter and a time",
            ),
            (format!("[{}]", words.join(", ")), "brackets"),
            (
                format!("@ [{}]", words.join(" ")),
                "a counter before brackets",
            ),
            (format!("@\t{decimal_commas}"), "decimal commas"),
        ] {
            for format in ["auto", "lines"] {
                let format = format.parse().expect("a format");
                let mut intake = FrameIntake::new(&pad, format);
                let text: String = (7..17)
                    .map(|number| format!("{}\r\n", line.replace('@', &number.to_string())))
                    .collect();
                let readings = readings_of(&mut intake, text.as_bytes());
                assert_eq!((frames(&readings), lost(&readings)), (10, 0), "{case}");
                let SourceReading::Frame(frame) = &readings[9] else {
                    panic!("{case}: {readings:?}");
                };
                assert!((frame.volts[3] - volts[3]).abs() < 1e-4, "{case}");
            }
        }
    }

    #[test]
    fn a_cut_line_is_never_a_frame_of_another_layout() {
        let pad = pad("openeit-lattice");
        let volts = rest(&pad);
        let mut intake = FrameIntake::new(&pad, WireFormat::OpenEit.into());
        let whole = openeit::encode(&volts);
        let cut = openeit::encode(&volts[..104]);
        let sound: String = std::iter::repeat_n(whole.as_str(), 3).collect();
        assert_eq!(frames(&readings_of(&mut intake, sound.as_bytes())), 3);
        let readings = readings_of(
            &mut intake,
            format!("{cut}{cut}{whole}{cut}{cut}{whole}").as_bytes(),
        );
        assert_eq!((frames(&readings), lost(&readings)), (2, 4));
    }

    #[test]
    fn a_board_of_another_protocol_is_refused_with_a_clear_error() {
        let mut intake = FrameIntake::new(&pad("edinburgh-lattice"), WireFormat::OpenEit.into());
        let text: String =
            std::iter::repeat_n(openeit::encode(&rest(&pad("openeit-lattice"))), 3).collect();
        let error = intake
            .feed(0, 0, text.as_bytes(), &mut VecDeque::new())
            .expect_err("192 for 208");
        assert!(
            error.to_string().contains("192 voltages of opposite drive"),
            "{error}"
        );
    }
}
