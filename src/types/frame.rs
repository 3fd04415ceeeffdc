//! One reading of the whole pad.

use super::Nanos;

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
