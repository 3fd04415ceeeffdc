//! From bytes to frames of the pad: dialect, count of values, order, losses, time. Fed bytes, without IO.
//!
//! Until the same plausible number of values has come [`SURE_FRAMES`] times in a row nothing is a frame: a line that was cut
//! must not pass for one of another layout. Their median tells the order. From then on a frame of another number is
//! garbled, until the board has gone over to that for good.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::pad::{Channel, Pad};
use crate::source::arrangement::{Arrangement, plausible_counts};
use crate::source::clock::DeviceClock;
use crate::source::wire::{Decoded, Dialect, Format, WireFrame, Wiring};
use crate::source::{Reading, SourceError};
use crate::types::{Frame, Nanos};

/// Frames of the same number of values that make sure.
const SURE_FRAMES: usize = 3;
/// A gap in the board's count larger than this is a board that began anew, not frames that were lost.
const LARGEST_GAP: u32 = 100_000;

/// What comes from a board, made frames of a pad.
pub(super) struct Intake {
    pad: Pad,
    format: Format,
    dialect: Box<dyn Dialect>,
    counts: Vec<usize>,
    arrangement: Option<Arrangement>,
    /// What the board said its values are readings of when that was found.
    listing: Option<Arc<[Channel]>>,
    /// Frames of a number of values that is not yet sure, with their arrival.
    unsure: Vec<(WireFrame, Nanos)>,
    clock: DeviceClock,
    sequence: Option<u32>,
    /// Whether a frame has come since the port was opened: what is garbled before was cut by the opening.
    begun: bool,
    decoded: Vec<Decoded>,
}

impl Intake {
    pub(super) fn new(pad: &Pad, format: Format) -> Self {
        Self {
            dialect: format.dialect(&Wiring::of_pad(pad)),
            counts: plausible_counts(pad),
            pad: pad.clone(),
            format,
            arrangement: None,
            listing: None,
            unsure: Vec::new(),
            clock: DeviceClock::default(),
            sequence: None,
            begun: false,
            decoded: Vec::new(),
        }
    }

    /// Takes bytes that came at a time. `now_ns` runs on while the board is away, `opened_ns` is when it came back.
    ///
    /// # Errors
    /// A board that measures with another protocol than the pad's.
    pub(super) fn feed(
        &mut self,
        now_ns: Nanos,
        opened_ns: Nanos,
        bytes: &[u8],
        readings: &mut VecDeque<Reading>,
    ) -> Result<(), SourceError> {
        let mut decoded = std::mem::take(&mut self.decoded);
        self.dialect
            .feed(now_ns.saturating_sub(opened_ns), bytes, &mut decoded);
        for one in decoded.drain(..) {
            match one {
                Decoded::Frame(frame) => self.frame(frame, now_ns, readings)?,
                Decoded::Garbled { reason, .. } if self.begun => {
                    // Where frames are counted, the next one's number tells how many were lost.
                    let frames = u64::from(self.sequence.is_none());
                    readings.push_back(Reading::Skipped { reason, frames });
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

    /// What the board must be told now.
    pub(super) fn say(&mut self, now_ns: Nanos, opened_ns: Nanos) -> Option<Vec<u8>> {
        self.dialect.say(now_ns.saturating_sub(opened_ns))
    }

    pub(super) fn farewell(&self) -> &'static [u8] {
        self.dialect.farewell()
    }

    /// The board came back: what was half there is forgotten, its order is not.
    pub(super) fn reopened(&mut self) {
        self.dialect.reopened();
        self.clock.untie();
        self.unsure.clear();
        self.sequence = None;
        self.begun = false;
    }

    fn frame(
        &mut self,
        frame: WireFrame,
        now_ns: Nanos,
        readings: &mut VecDeque<Reading>,
    ) -> Result<(), SourceError> {
        let count = frame.values.len();
        if let Some(arrangement) = &self.arrangement
            && arrangement.values() == count
            && self.listing == frame.listing
        {
            let volts = arrangement.apply(&frame.values);
            self.unsure.clear();
            self.arrived(&frame, now_ns, volts, readings);
            return Ok(());
        }
        if !self.counts.contains(&count) {
            self.odd(count, readings);
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
            self.odd(count, readings);
        }
        self.unsure.push((frame, now_ns));
        if self.unsure.len() < SURE_FRAMES {
            return Ok(());
        }
        let listing = self.unsure[0].0.listing.clone();
        let found = Arrangement::find(
            &self.median(),
            listing.as_deref(),
            self.format.order,
            &self.pad,
        );
        let found = match found {
            Ok(found) => found,
            // Damage may look like another board; the one that was there goes on.
            Err(_) if self.arrangement.is_some() => {
                self.unsure.clear();
                return Ok(());
            }
            Err(error) => return Err(SourceError::Arrangement(error)),
        };
        tracing::info!(target: "gelpad::told", "{}", found.told());
        let had_one = self.arrangement.is_some();
        for (frame, arrived_ns) in std::mem::take(&mut self.unsure) {
            let volts = found.apply(&frame.values);
            // Frames that were told as lost are not played late.
            if !had_one {
                self.arrived(&frame, arrived_ns, volts, readings);
            }
        }
        self.arrangement = Some(found);
        self.listing = listing;
        Ok(())
    }

    fn arrived(
        &mut self,
        frame: &WireFrame,
        arrived_ns: Nanos,
        volts: Vec<f32>,
        readings: &mut VecDeque<Reading>,
    ) {
        self.begun = true;
        if let (Some(before), Some(sequence)) = (self.sequence, frame.sequence) {
            let gap = sequence.wrapping_sub(before).wrapping_sub(1);
            if (1..=LARGEST_GAP).contains(&gap) {
                let are = if gap == 1 { "frame is" } else { "frames are" };
                readings.push_back(Reading::Skipped {
                    reason: format!("{gap} {are} missing by the board's count"),
                    frames: u64::from(gap),
                });
            }
        }
        self.sequence = frame.sequence;
        let t_ns = self.clock.time(frame.stamp, arrived_ns);
        readings.push_back(Reading::Frame(Frame { t_ns, volts }));
    }

    fn odd(&self, count: usize, readings: &mut VecDeque<Reading>) {
        let wanted = self
            .arrangement
            .as_ref()
            .map_or(self.pad.channels(), Arrangement::values);
        let reason = if count == wanted {
            format!("{count} values of other drives than before")
        } else {
            format!("{count} values where there should be {wanted}: is it another pad (--pad)?")
        };
        readings.push_back(Reading::Skipped { reason, frames: 1 });
    }

    /// Value by value: one that was garbled does not tell the order.
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
    use crate::source::wire::{FormatKind, openeit};

    fn pad(name: &str) -> Pad {
        Pad::from_toml(name, shipped_pad(name).expect("shipped").toml).expect("sound")
    }

    fn rest(pad: &Pad) -> Vec<f32> {
        let volts = SimulatedPad::new(pad).and_then(|simulated| simulated.volts(&[]));
        let volts = volts.expect("solved");
        volts.into_iter().map(|volt| 1e3 * volt as f32).collect()
    }

    fn fed(intake: &mut Intake, bytes: &[u8]) -> Vec<Reading> {
        let mut readings = VecDeque::new();
        intake.feed(5, 0, bytes, &mut readings).expect("fits");
        readings.into()
    }

    fn frames(readings: &[Reading]) -> usize {
        let is_frame = |reading: &&Reading| matches!(reading, Reading::Frame(_));
        readings.iter().filter(is_frame).count()
    }

    fn lost(readings: &[Reading]) -> u64 {
        let frames = |reading: &Reading| match reading {
            Reading::Skipped { frames, .. } => *frames,
            _ => 0,
        };
        readings.iter().map(frames).sum()
    }

    #[test]
    fn losses_are_counted_by_the_boards_numbers_once() {
        let pad = pad("edinburgh-lattice");
        let volts = rest(&pad);
        let mut intake = Intake::new(&pad, FormatKind::Gelpad.into());
        let packet = |n: u32| encode(Values::F32, n, n.wrapping_mul(1000), &volts);
        // The count runs over on the way.
        let begin: Vec<u8> = (0..5_u32).flat_map(|n| packet(n.wrapping_sub(2))).collect();
        assert_eq!(frames(&fed(&mut intake, &begin)), 5);
        let mut damaged = packet(3);
        damaged[100] ^= 0x55;
        // Number 3 is garbled, 4 and 5 never came.
        let readings = fed(&mut intake, &[damaged, packet(6)].concat());
        assert_eq!((frames(&readings), lost(&readings)), (1, 3));
        // A board that was reset counts anew: nothing says that frames were lost.
        let readings = fed(&mut intake, &packet(0));
        assert_eq!((frames(&readings), lost(&readings)), (1, 0));
    }

    #[test]
    fn a_cut_line_is_never_a_frame_of_another_layout() {
        let pad = pad("openeit-lattice");
        let volts = rest(&pad);
        let mut intake = Intake::new(&pad, FormatKind::OpenEit.into());
        let whole = openeit::encode(&volts);
        let cut = openeit::encode(&volts[..104]);
        let sound: String = std::iter::repeat_n(whole.as_str(), 3).collect();
        assert_eq!(frames(&fed(&mut intake, sound.as_bytes())), 3);
        let readings = fed(
            &mut intake,
            format!("{cut}{cut}{whole}{cut}{cut}{whole}").as_bytes(),
        );
        assert_eq!((frames(&readings), lost(&readings)), (2, 4));
    }

    #[test]
    fn a_board_of_another_protocol_ends_it_with_a_clear_error() {
        let mut intake = Intake::new(&pad("edinburgh-lattice"), FormatKind::OpenEit.into());
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
