//! Wire formats, one a file: decoders that are fed bytes and do no IO.

pub mod openeit;

/// What a decoder makes of the bytes so far.
#[derive(Clone, Debug, PartialEq)]
pub enum Decoded {
    /// The voltages of one frame.
    Volts(Vec<f32>),
    /// A line that should have been a frame but is not.
    Garbled {
        /// Why.
        reason: String,
    },
}
