//! One reading of the whole pad, and the state of a source that has no image.

use super::{Button, Nanos};

/// The measured voltages of one frame.
///
/// `f32` from the decoder to the file: that is what boards send, and what a recording keeps.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// When the device took the frame, in its own time.
    pub t_ns: Nanos,
    /// One voltage a channel, in the pad's measurement order. The unit is the instrument's: only
    /// relative differences are used.
    pub volts: Vec<f32>,
}

/// The state of a physical gamepad or switch: a source without an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// When the state was read.
    pub t_ns: Nanos,
    /// The buttons that are down.
    pub down: Vec<Button>,
}
