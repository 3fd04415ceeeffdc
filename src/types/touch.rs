//! Contacts (one frame) and touches (through time).

use super::{Nanos, PointMm};

/// One place where the pad is pressed in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Centre, mm.
    pub centre_mm: PointMm,
    /// Footprint, mm2.
    pub area_mm2: f64,
    /// How hard, 0 to 1.
    pub force: f64,
    /// How sure we are that it is one, 0 to 1.
    pub confidence: f64,
}

/// Names one touch for as long as the program runs; never used twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TouchId(pub u64);

/// Where a touch is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// First frame.
    Down,
    /// Seen before and still there.
    Move,
    /// No longer there: `contact` is where it was last.
    Up,
}

/// A contact followed through time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Its name.
    pub id: TouchId,
    /// Where it is in its life.
    pub phase: Phase,
    /// When it was first seen.
    pub since_ns: Nanos,
    /// Where it is, as measured in this frame (neither smoothed nor delayed).
    pub contact: Contact,
}
