//! A hold, or long press: still there after a time, moved less than the slop.
//!
//! ```text
//! touch    ____/~~~~~~~~~~~~~\____
//! output   ___________/~~~~~~\____
//!              | hold |
//! ```

use crate::types::Nanos;

/// A touch that may become a hold.
#[derive(Clone, Copy, Debug)]
pub(super) enum Hold {
    /// Becomes one then.
    Waiting { at: Nanos, slop_mm: f64 },
    /// Is one.
    Held,
    /// Moved too far.
    Missed,
}

impl Hold {
    pub(super) fn new(down_ns: Nanos, after_ns: Nanos, slop_mm: f64) -> Self {
        Self::Waiting {
            at: down_ns + after_ns,
            slop_mm,
        }
    }

    pub(super) fn next_due(&self) -> Option<Nanos> {
        match self {
            Self::Waiting { at, .. } => Some(*at),
            Self::Held | Self::Missed => None,
        }
    }

    /// The touch is so far from where it went down.
    pub(super) fn moved(&mut self, distance_mm: f64) {
        if let Self::Waiting { slop_mm, .. } = self
            && distance_mm >= *slop_mm
        {
            *self = Self::Missed;
        }
    }

    /// Whether it becomes a hold at this time.
    pub(super) fn tick(&mut self, t_ns: Nanos) -> bool {
        let becomes = matches!(self, Self::Waiting { at, .. } if *at <= t_ns);
        if becomes {
            *self = Self::Held;
        }
        becomes
    }
}
