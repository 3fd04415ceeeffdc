//! Parts of frames that are still arriving: readings are handed on drive by drive, as [`Part`]s, where a board takes long to send a
//! frame.
//!
//! Parts are used once the order of the readings is known, each drive's readings arrive after those of the drive before, and
//! a frame takes at least [`LONG_NS`] from its first readings to its end. Nothing is gained with faster boards. The
//! readings of a frame that looks wrong are held until its end, where it is checked like any other frame: a frame out of
//! its order, and one whose readings look shifted by one, as after a lost comma.
//!
//! Invariant: parts of a frame are handed on in their order, each once, and never after a part of a later frame.

use std::collections::VecDeque;

use crate::source::SourceReading;
use crate::source::arrangement::{Arrangement, PartPlace};
use crate::source::clock::DeviceClock;
use crate::source::wire::{Readings, Stamp};
use crate::types::{NANOS_PER_MS, Nanos, Part};

/// A frame that takes this long to arrive is handed on in parts, ...
const LONG_NS: f64 = 4.0 * NANOS_PER_MS as f64;
/// ... until frames arrive within this time.
const SHORT_NS: f64 = NANOS_PER_MS as f64;
/// Weight of the last frame in the mean of these times.
const WEIGHT: f64 = 0.25;
/// Readings are shifted if they fit neighbouring channels this many times as well as their own, ...
const SHIFTED_FIT: f32 = 3.0;
/// ... and differ from their own by more than this share, on average.
const SHIFTED_SHARE: f32 = 0.05;

/// Hands on the parts of the frame that is arriving.
#[derive(Default)]
pub(super) struct PartIntake {
    /// Whether the player wants parts.
    is_wanted: bool,
    /// The parts of a frame, if the order of the readings allows them.
    places: Vec<PartPlace>,
    is_used: bool,
    /// Mean time from the first readings of a frame to its end, ns.
    arrival_ns: f64,
    /// Mean time from frame to frame, ns.
    period_ns: f64,
    /// The first values of the frame under way, and its number.
    values: Vec<f32>,
    sequence: Option<u32>,
    first_ns: Option<Nanos>,
    /// Parts of it that were handed on.
    done: usize,
    /// It is handed on when it is complete.
    is_held: bool,
    /// Voltages and end of the last frame.
    last_volts: Vec<f32>,
    last_end_ns: Option<Nanos>,
    last_sequence: Option<u32>,
}

impl PartIntake {
    /// From now on frames are handed on in parts where that helps.
    pub(super) fn switch_on(&mut self) {
        self.is_wanted = true;
    }

    /// The order of the readings is known.
    pub(super) fn set_arrangement(&mut self, arrangement: &Arrangement) {
        self.places = match self.is_wanted {
            true => arrangement.parts().unwrap_or_default(),
            false => Vec::new(),
        };
        self.reset();
    }

    /// The board is back, or has changed.
    pub(super) fn reset(&mut self) {
        self.is_used = false;
        self.arrival_ns = 0.0;
        self.last_volts.clear();
        self.last_end_ns = None;
        self.last_sequence = None;
        self.drop_frame();
    }

    /// The frame under way is damaged.
    pub(super) fn abandon(&mut self) {
        self.drop_frame();
        self.is_held = true;
    }

    fn drop_frame(&mut self) {
        self.values.clear();
        self.first_ns = None;
        self.done = 0;
        self.is_held = false;
    }

    /// Takes readings of the frame under way; `leading` columns before the readings do not count.
    pub(super) fn take_readings(
        &mut self,
        readings: Readings,
        leading: usize,
        now_ns: Nanos,
        (arrangement, clock): (&Arrangement, &mut DeviceClock),
        out: &mut VecDeque<SourceReading>,
    ) {
        if self.places.is_empty() {
            return;
        }
        let skipped = leading.saturating_sub(readings.first);
        let first = readings.first.saturating_sub(leading);
        let fresh = readings.values.get(skipped..).unwrap_or_default();
        if readings.first == 0 {
            self.drop_frame();
            self.first_ns = Some(now_ns);
            self.sequence = readings.sequence;
            // A frame that is late, repeated or after a gap is checked when it is complete.
            self.is_held = match (self.last_sequence, readings.sequence) {
                (Some(last), Some(this)) => this != last.wrapping_add(1),
                _ => false,
            };
        }
        if first != self.values.len() || readings.sequence != self.sequence {
            self.is_held = true;
            return;
        }
        self.values.extend_from_slice(fresh);
        self.values.truncate(arrangement.values());
        if self.is_used && !self.is_held {
            self.hand_on(readings.stamp, now_ns, (arrangement, clock), out);
        }
    }

    /// Hands on the parts that are complete.
    fn hand_on(
        &mut self,
        stamp: Option<Stamp>,
        now_ns: Nanos,
        (arrangement, clock): (&Arrangement, &mut DeviceClock),
        out: &mut VecDeque<SourceReading>,
    ) {
        while let Some(place) = self.places.get(self.done) {
            if place.needs > self.values.len() {
                return;
            }
            let volts = arrangement.apply_part(&self.values, place);
            if self.is_shifted(&volts, place.first) {
                self.is_held = true;
                return;
            }
            let t_ns = clock.frame_time(stamp, now_ns);
            out.push_back(SourceReading::Part(Part {
                t_ns,
                first: place.first,
                volts,
            }));
            self.done += 1;
        }
    }

    /// Takes a complete frame, whose number was checked. Returns whether its parts were handed on; else it is handed on whole.
    pub(super) fn end_frame(
        &mut self,
        volts: &[f32],
        (sequence, stamp): (Option<u32>, Option<Stamp>),
        now_ns: Nanos,
        clock: &mut DeviceClock,
        out: &mut VecDeque<SourceReading>,
    ) -> bool {
        if self.places.is_empty() {
            return false;
        }
        let is_in_parts = self.is_used;
        if is_in_parts {
            // Parts of another frame do not count: this one is handed on from its start.
            let done = if self.sequence == sequence {
                self.done
            } else {
                0
            };
            for place in &self.places[done..] {
                out.push_back(SourceReading::Part(Part {
                    t_ns: clock.frame_time(stamp, now_ns),
                    first: place.first,
                    volts: volts[place.first..place.first + place.channels].to_vec(),
                }));
            }
        }
        self.learn_times(now_ns);
        self.last_volts.clear();
        self.last_volts.extend_from_slice(volts);
        self.last_sequence = sequence;
        self.drop_frame();
        is_in_parts
    }

    /// Learns how long frames take.
    fn learn_times(&mut self, now_ns: Nanos) {
        let took_ns = self
            .first_ns
            .map_or(0, |first| now_ns.saturating_sub(first));
        self.arrival_ns += WEIGHT * (took_ns as f64 - self.arrival_ns);
        if let Some(before) = self.last_end_ns {
            let period_ns = now_ns.saturating_sub(before) as f64;
            self.period_ns = match self.period_ns {
                0.0 => period_ns,
                mean => mean + WEIGHT * (period_ns - mean),
            };
        }
        self.last_end_ns = Some(now_ns);
        let limit_ns = if self.is_used { SHORT_NS } else { LONG_NS };
        if self.is_used != (self.arrival_ns >= limit_ns) {
            self.is_used = !self.is_used;
            let how = if self.is_used {
                "drive by drive"
            } else {
                "whole"
            };
            tracing::debug!("frames are handed on {how}");
        }
    }

    /// Spreads the times of parts that arrived together: each was read a drive's time after the one before.
    pub(super) fn spread_times(&self, before_ns: Nanos, parts: &mut [&mut Part]) {
        let Some(drive_ns) = self.drive_ns() else {
            return;
        };
        let count = parts.len() as u64;
        for (index, part) in (0..).zip(parts) {
            let early_ns = drive_ns * (count - 1 - index);
            part.t_ns = part.t_ns.saturating_sub(early_ns).max(before_ns);
        }
    }

    fn drive_ns(&self) -> Option<Nanos> {
        let drives = self.places.len() as f64;
        (drives > 0.0).then(|| (self.period_ns / drives) as Nanos)
    }

    /// Whether readings, from some reading on, fit their neighbouring channels better than their own: a value of the frame was lost
    /// or doubled.
    fn is_shifted(&self, volts: &[f32], first: usize) -> bool {
        let off = |k: usize, shift: isize| -> f32 {
            let channel = (first + k).checked_add_signed(shift);
            let last = channel.and_then(|channel| self.last_volts.get(channel));
            last.map_or(0.0, |last| {
                let share = (volts[k] - last).abs() / last.abs().max(1e-12);
                share.min(10.0)
            })
        };
        let own: f32 = (0..volts.len()).map(|k| off(k, 0)).sum();
        let fits_shifted = |shift| {
            // From the back: the sum if the readings from k on are shifted.
            let mut sum = own;
            (0..volts.len()).rev().any(|k| {
                sum += off(k, shift) - off(k, 0);
                SHIFTED_FIT * sum < own
            })
        };
        own > SHIFTED_SHARE * volts.len() as f32 && (fits_shifted(1) || fits_shifted(-1))
    }
}
