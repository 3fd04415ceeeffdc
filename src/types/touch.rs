//! Contacts (one frame) and touches (through time).

use super::{Nanos, PointMm};

/// One place where the pad is pressed in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Centre, mm.
    pub centre_mm: PointMm,
    /// Footprint, mm2.
    pub area_mm2: f64,
    /// Force, 0 to 1.
    pub force: f64,
    /// Confidence that it is a contact, 0 to 1.
    pub confidence: f64,
}

/// Identifies a touch; never reused while the program runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TouchId(pub u64);

/// The phase of a touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// First frame.
    Down,
    /// Down since an earlier frame.
    Move,
    /// Lifted; `contact` is the last one.
    Up,
}

/// A contact followed through time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Its id.
    pub id: TouchId,
    /// Its phase.
    pub phase: Phase,
    /// Time of its first frame.
    pub since_ns: Nanos,
    /// Its contact in this frame, neither smoothed nor delayed.
    pub contact: Contact,
}
