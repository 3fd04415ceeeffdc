//! A checked binding: the gesture, what it drives, and how.

use super::gestures::Gesture;
use super::target::Target;
use crate::types::Nanos;

/// What a touch in a region does.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    /// Indices into [`super::Profile::regions`]; empty for the whole pad, unless there are parts.
    pub regions: Vec<usize>,
    /// Indices into [`super::Profile::parts`]: parts of a gamepad that play it as a touch does.
    pub parts: Vec<usize>,
    /// Index into [`super::Profile::layers`]; none for the base layer, which is always on.
    pub layer: Option<usize>,
    /// What the touch must do.
    pub gesture: Gesture,
    /// How the targets are driven.
    pub mode: Mode,
    /// What is driven.
    pub targets: Vec<Target>,
}

/// How a gesture drives its targets.
#[derive(Clone, Debug, PartialEq)]
pub enum Mode {
    /// Down as long as the gesture.
    Direct,
    /// Short or long: the length of the gesture selects one of two lengths of the press.
    Classified(Latch),
    /// Down for a fixed length, however long the gesture lasts.
    Latch(Nanos),
    /// Down with one gesture, up with the next.
    Toggle,
    /// Pressed repeatedly as long as the gesture.
    Turbo {
        /// From the first press to the second.
        first_ns: Nanos,
        /// From each further press to the next.
        period_ns: Nanos,
    },
    /// Sticky keys: down until another press is over; after a second gesture, down until a third.
    Sticky,
    /// A sequence with its own times, which runs to its end.
    Macro(Vec<MacroStep>),
}

/// A step of a macro.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MacroStep {
    /// Goes down.
    Press(Target),
    /// Goes up.
    Release(Target),
    /// Waits.
    Wait(Nanos),
}

/// The two lengths of a classified press, and the limit between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Latch {
    /// A touch that lasts this long is long.
    pub long_after_ns: Nanos,
    /// Least length of a short press.
    pub short_ns: Nanos,
    /// Length of a long press, whenever the touch lifts.
    pub long_ns: Nanos,
    /// Whether it goes down only when its length is known, instead of with the touch.
    pub when_decided: bool,
}
