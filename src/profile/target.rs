//! What a binding can drive.

/// Something that a gesture drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Index into [`super::Profile::outputs`].
    Output(usize),
    /// Index into [`super::Profile::layers`]: it is on while held.
    Layer(usize),
    /// The wheel turns by one notch: right and up are positive.
    Wheel {
        /// To the right.
        dx: i32,
        /// Up.
        dy: i32,
    },
    /// Releases everything and pauses, or ends the pause.
    Pause,
}
