//! What a touch does, checked: the gesture that it must be, and what then is driven, and how.

use crate::types::{Axis, Nanos};

/// What a touch in a region does.
#[derive(Clone, Debug, PartialEq)]
pub struct Binding {
    /// Indices into [`super::Profile::regions`]; empty for the whole pad, unless there are parts.
    pub regions: Vec<usize>,
    /// Indices into [`super::Profile::parts`]: parts of a gamepad that play it as a touch does.
    pub parts: Vec<usize>,
    /// Index into [`super::Profile::layers`]; none is the ground that is always there.
    pub layer: Option<usize>,
    /// What the touch must be.
    pub gesture: Gesture,
    /// How its targets are driven.
    pub mode: Mode,
    /// What is driven.
    pub targets: Vec<Target>,
}

/// Something that a gesture drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Index into [`super::Profile::outputs`].
    Output(usize),
    /// Index into [`super::Profile::layers`]: its bindings count while it is held.
    Layer(usize),
    /// The wheel turns by a notch: right and up positive.
    Wheel {
        /// To the right.
        dx: i32,
        /// Up.
        dy: i32,
    },
    /// Everything is released and nothing counts until it comes again.
    Pause,
}

/// How a gesture drives its targets.
#[derive(Clone, Debug, PartialEq)]
pub enum Mode {
    /// Down while it lasts: length is length.
    Direct,
    /// The paper's short and long press: down with the gesture; the time it lasts selects one of two lengths.
    Classified(Latch),
    /// Down for a fixed length, however long the gesture lasts.
    Latch(Nanos),
    /// Down with one gesture, up with the next.
    Toggle,
    /// Pressed again and again while it lasts.
    Turbo {
        /// From the first press to the second.
        first_ns: Nanos,
        /// From each further press to the next.
        period_ns: Nanos,
    },
    /// StickyKeys: down until another press is over; twice: down until a third time.
    Sticky,
    /// A sequence with its own times; runs to its end.
    Macro(Vec<MacroStep>),
}

/// A step of a macro.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MacroStep {
    /// Goes down.
    Press(Target),
    /// Comes up.
    Release(Target),
    /// Nothing for a time.
    Wait(Nanos),
}

/// The two lengths of a classified press, and what parts them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Latch {
    /// A touch that lasts this long is long.
    pub long_after_ns: Nanos,
    /// Least length of a short press.
    pub short_ns: Nanos,
    /// Length of a long press, whenever the touch lifts.
    pub long_ns: Nanos,
    /// Goes down when it is known to be short or long, not with the touch.
    pub when_decided: bool,
}

/// What a touch must be. Times and distances are half-open: at the threshold it is reached.
#[derive(Clone, Debug, PartialEq)]
pub enum Gesture {
    /// Any touch.
    Press,
    /// Lifted sooner than a time, moved less than a distance.
    Tap {
        /// The tapping term.
        within_ns: Nanos,
        /// The slop.
        slop_mm: f64,
    },
    /// Still down, and moved less than the slop, after a time.
    Hold {
        /// The time.
        after_ns: Nanos,
        /// The slop.
        slop_mm: f64,
    },
    /// The second of two touches, the first a tap, sooner than a time after it.
    DoubleTap {
        /// From the first's lift to the second.
        gap_ns: Nanos,
        /// The tapping term of the first.
        within_ns: Nanos,
    },
    /// A stroke.
    Swipe(Swipe),
    /// Every region is touched, and they were sooner than a time after each other.
    Chord {
        /// The time.
        window_ns: Nanos,
    },
    /// So many touches at once.
    Contacts {
        /// How many.
        count: usize,
    },
    /// Pressed harder than a level.
    Force {
        /// Goes down there.
        press: f64,
        /// Comes up below that.
        release: f64,
    },
    /// Directions from the middle of the region; each has its own target.
    Dpad(Dpad),
    /// A stick's two axes.
    Stick(Stick),
    /// Force as an axis.
    Trigger(Trigger),
    /// The mouse follows the touch.
    Pointer(Pointer),
    /// One thing when tapped, another when held.
    TapHold(TapHold),
}

/// A direction on the pad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Direction {
    /// Eighths of a turn, counter-clockwise from the right.
    pub eighth: u8,
}

/// A stroke in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swipe {
    /// Where it goes.
    pub direction: Direction,
    /// 4 or 8 directions are told apart.
    pub ways: u8,
    /// Touches that move together.
    pub fingers: usize,
    /// It is one when it has gone this far, ...
    pub distance_mm: f64,
    /// ... sooner than this.
    pub within_ns: Nanos,
}

/// A d-pad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dpad {
    /// 4 or 8 directions.
    pub ways: u8,
    /// Nothing nearer to the middle, share of half of the region's shorter side.
    pub dead_zone: f64,
    /// How wide diagonals are: 0 none, 0.5 as wide as the others, 1 everything.
    pub diagonal: f64,
    /// Right, up, left, down.
    pub targets: [Option<Target>; 4],
}

/// The shape of a stick's dead zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeadZone {
    /// Around the middle.
    Round,
    /// Each axis for itself.
    Square,
}

/// How a value 0..1 answers to a share 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    /// Nothing below this share.
    pub dead_zone: f64,
    /// Exponent: 1 straight, 2 finer near the middle.
    pub exponent: f64,
}

/// Gain by direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// To the right.
    pub right: f64,
    /// Up.
    pub up: f64,
    /// To the left.
    pub left: f64,
    /// Down.
    pub down: f64,
}

/// A stick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stick {
    /// Whether its middle is where the touch goes down, not the region's.
    pub floating: bool,
    /// Its dead zone's shape.
    pub dead_zone: DeadZone,
    /// How it answers.
    pub curve: Curve,
    /// Gain by direction.
    pub gains: Gains,
    /// Right positive.
    pub x: Option<Axis>,
    /// Up positive.
    pub y: Option<Axis>,
}

/// Force as an axis, 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trigger {
    /// Which.
    pub axis: Axis,
    /// How it answers.
    pub curve: Curve,
    /// Factor.
    pub gain: f64,
}

/// The mouse by a touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pointer {
    /// Whether the wheel turns instead of the pointer moving.
    pub wheel: bool,
    /// Pixels (or notches) a millimetre.
    pub gain: f64,
}

/// Who decides between tap and hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flavour {
    /// Only time: hold when the tapping term is over.
    TapPreferred,
    /// ... or when another touch came and went meanwhile.
    Balanced,
    /// ... or when another touch came meanwhile.
    HoldPreferred,
    /// The tap is pressed at once; when the term is over it gives way to the hold.
    Speculative,
}

/// Tap or hold.
#[derive(Clone, Debug, PartialEq)]
pub struct TapHold {
    /// Who decides.
    pub flavour: Flavour,
    /// The tapping term.
    pub term_ns: Nanos,
    /// A touch sooner than this after a tap is a tap at once, for as long as it lasts.
    pub quick_tap_ns: Nanos,
    /// A touch sooner than this after any other press is a tap at once.
    pub prior_idle_ns: Nanos,
    /// What the hold drives; the binding's targets are the tap's.
    pub hold: Vec<Target>,
}
