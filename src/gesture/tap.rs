//! A tap: lifted sooner than the tapping term, moved less than the slop.
//!
//! ```text
//! touch    ____/~~\__________/~~~~~~~~~~~\__
//! output   _______/\________________________
//!              |term |       |term |
//! ```

use crate::types::Nanos;

/// A touch that may become a tap.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tap {
    until_ns: Nanos,
    slop_mm: f64,
    strayed: bool,
}

impl Tap {
    pub(super) fn new(down_ns: Nanos, within_ns: Nanos, slop_mm: f64) -> Self {
        Self {
            until_ns: down_ns + within_ns,
            slop_mm,
            strayed: false,
        }
    }

    /// The touch is so far from where it went down.
    pub(super) fn moved(&mut self, distance_mm: f64) {
        self.strayed |= distance_mm >= self.slop_mm;
    }

    /// Whether the touch that lifts now was a tap.
    pub(super) fn is_tap(&self, t_ns: Nanos) -> bool {
        !self.strayed && t_ns < self.until_ns
    }
}
