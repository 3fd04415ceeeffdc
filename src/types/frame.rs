//! One frame of voltages.

use super::Nanos;

/// The measured voltages of one frame, as `f32` from decoder to recording: boards send no more.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Time stamp of the device.
    pub t_ns: Nanos,
    /// One voltage per channel, in the pad's measurement order, in any unit: only relative changes are used.
    pub volts: Vec<f32>,
}

/// Some readings of a frame that were taken at one moment: those of a drive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// When they were taken.
    pub t_ns: Nanos,
    /// The channel of the first of them. The part that holds the pad's last channel ends a frame.
    pub first: usize,
    /// Consecutive readings, in the pad's measurement order.
    pub volts: Vec<f32>,
}
