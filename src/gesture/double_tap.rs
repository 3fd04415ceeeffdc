//! A double tap: a tap, and a second touch soon after it in the same region. It is down with the second touch.
//!
//! ```text
//! touch    ____/~~\____/~~~~~~\____
//! output   ____________/~~~~~~\____
//!                 | gap |
//! ```

use super::tap::Tap;
use crate::types::Nanos;

/// A first touch moves less than this.
const SLOP_MM: f64 = 8.0;

/// The first touch or the second.
#[derive(Clone, Copy, Debug)]
pub(super) enum DoubleTap {
    First(Tap),
    Second,
}

impl DoubleTap {
    /// A touch that goes down, after a first tap that lifted at a time.
    pub(super) fn new(
        t_ns: Nanos,
        first_ns: Option<Nanos>,
        gap_ns: Nanos,
        within_ns: Nanos,
    ) -> Self {
        match first_ns {
            Some(first_ns) if t_ns < first_ns + gap_ns => Self::Second,
            _ => Self::First(Tap::new(t_ns, within_ns, SLOP_MM)),
        }
    }
}
