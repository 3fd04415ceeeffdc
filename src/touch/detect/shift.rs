//! Frames in which all readings are scaled alike: another gain of the board, a damaged frame, a loose plug.
//!
//! No touch multiplies every reading by the same factor. Such a frame costs itself; when the factor stays, it is the board's new gain and the
//! reference follows it, so that play goes on with the touches that are down.

use super::Detector;
use crate::types::{Frame, NANOS_PER_MS, Nanos, Touch};

/// Readings count as scaled alike if the median change exceeds this share ...
const LEAST_SHIFT: f64 = 0.04;
/// ... and most changes lie within this share of it.
const ALIKE: f64 = 0.25;
/// A factor that stays for so long is the board's gain.
const STAYS_NS: Nanos = 40 * NANOS_PER_MS;
/// Two shifted frames agree if their factors differ by less than this share.
const AGREES: f64 = 0.03;
/// Below this share of the reference nothing is read at all.
const LEAST_FACTOR: f64 = 0.02;
/// Held touches wait this long for the readings to return.
const WAIT_NS: Nanos = 500 * NANOS_PER_MS;

/// The shift of the last frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct GainShift {
    /// The factor, and since when it is seen.
    seen: Option<(f64, Nanos)>,
}

impl Detector {
    /// Whether the frame is scaled as a whole and must be skipped.
    pub(super) fn is_shifted(&mut self, frame: &Frame, changed: &mut Vec<Touch>) -> bool {
        let Some(factor) = self.common_factor() else {
            self.shift.seen = None;
            return false;
        };
        let since = match self.shift.seen {
            Some((before, since)) if (factor - before).abs() < AGREES * before.abs() => since,
            _ => frame.t_ns,
        };
        self.shift.seen = Some((factor, since));
        let lasted_ns = frame.t_ns.saturating_sub(since);
        if lasted_ns >= STAYS_NS && factor.abs() > LEAST_FACTOR {
            self.reference.scale(factor);
            self.reference
                .relative_changes(&frame.volts, &mut self.changes);
            self.shift.seen = None;
            return false;
        }
        if lasted_ns > WAIT_NS {
            self.lift_all(changed);
        }
        true
    }

    /// The factor by which all readings differ from the reference, if they do.
    fn common_factor(&self) -> Option<f64> {
        let mut changes: Vec<f64> = (0..self.changes.len())
            .filter(|channel| !self.reference.is_muted(*channel))
            .map(|channel| f64::from(self.changes[channel]))
            .map(|change| if change.is_finite() { change } else { f64::MAX })
            .collect();
        if changes.is_empty() {
            return None;
        }
        changes.sort_by(f64::total_cmp);
        let median = changes[changes.len() / 2];
        if median.abs() < LEAST_SHIFT || median == f64::MAX {
            return None;
        }
        let [low, high] = [changes.len() / 10, changes.len() * 9 / 10].map(|index| changes[index]);
        let is_alike = (high - median).max(median - low) < ALIKE * median.abs();
        is_alike.then_some(1.0 + median)
    }
}
