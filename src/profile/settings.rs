//! Settings of a whole profile: times, accessibility, safety, and the orientation of the pad.

use crate::types::{Nanos, PointMm};

/// When a touch acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activate {
    /// At once.
    Down,
    /// When it lifts, if it is still in its region: sliding off cancels it.
    Up,
}

/// Which place of a touch counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Assist {
    /// Every place, as it moves.
    Off,
    /// Where it went down.
    First,
    /// Where it lifts; it acts then.
    Last,
}

/// The mirror image of the pad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mirror {
    /// As it is.
    None,
    /// Left and right are swapped.
    Horizontal,
    /// Top and bottom are swapped.
    Vertical,
    /// Both.
    Both,
}

/// The rotation of the pad, counter-clockwise as the player sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rotation {
    /// As it is.
    None,
    /// A quarter turn to the left: the pad's right edge is at the top.
    Quarter,
    /// Upside down.
    Half,
    /// A quarter turn to the right.
    ThreeQuarters,
}

/// A rectangle of the pad, in shares of its width and height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// Left.
    pub x: f64,
    /// Bottom.
    pub y: f64,
    /// Width.
    pub w: f64,
    /// Height.
    pub h: f64,
}

impl Area {
    /// The whole pad.
    pub const PAD: Self = Self {
        x: 0.0,
        y: 0.0,
        w: 1.0,
        h: 1.0,
    };
}

/// Checked settings. A time of zero switches its function off.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Shortest press: games that poll would miss a shorter one.
    pub min_hold_ns: Nanos,
    /// Shortest release before the same output is pressed again; zero never delays a press.
    pub min_gap_ns: Nanos,
    /// A longer press is released by force.
    pub max_hold_ns: Option<Nanos>,
    /// SlowKeys: a touch counts only after it was held this long.
    pub slow_keys_ns: Nanos,
    /// BounceKeys: a re-press of a region sooner than this after its last accepted release is ignored.
    pub bounce_keys_ns: Nanos,
    /// A touch counts when it has stayed in one place this long.
    pub dwell_ns: Nanos,
    /// Size of one place for `dwell_ns`.
    pub dwell_mm: f64,
    /// Moves smaller than this are ignored; a finger that returns within it is the same touch.
    pub tremor_mm: f64,
    /// A finger that returns sooner than this has not lifted.
    pub tremor_ns: Nanos,
    /// When a touch acts.
    pub activate: Activate,
    /// Which place counts.
    pub assist: Assist,
    /// Larger contacts are ignored, mm2.
    pub rest_area_mm2: Option<f64>,
    /// Whether modifier keys stay down until another press is over; bindings of them have [`super::Mode::Sticky`] then.
    pub sticky_keys: bool,
    /// This many contacts at once release everything and pause.
    pub panic_contacts: Option<usize>,
    /// The force range of the person: force that counts as none, and as full.
    pub force_range: [f64; 2],
    /// Whether the pad is mirrored.
    pub mirror: Mirror,
    /// How the pad is turned, after mirroring.
    pub rotate: Rotation,
    /// The part of the pad that the regions' 0..1 covers.
    pub area: Area,
    /// The part of the pad that the person can reach, if less than all of it.
    pub reachable: Option<Area>,
}

impl Settings {
    /// The pad's size (width, height) as the player sees it.
    #[must_use]
    pub fn size_as_player_sees_mm(&self, [width, height]: [f64; 2]) -> [f64; 2] {
        match self.rotate {
            Rotation::None | Rotation::Half => [width, height],
            Rotation::Quarter | Rotation::ThreeQuarters => [height, width],
        }
    }

    /// A place on a pad of a size, as the player sees it.
    #[must_use]
    pub fn as_player_sees(&self, [x, y]: PointMm, [width, height]: [f64; 2]) -> PointMm {
        let x = match self.mirror {
            Mirror::Horizontal | Mirror::Both => width - x,
            Mirror::None | Mirror::Vertical => x,
        };
        let y = match self.mirror {
            Mirror::Vertical | Mirror::Both => height - y,
            Mirror::None | Mirror::Horizontal => y,
        };
        match self.rotate {
            Rotation::None => [x, y],
            Rotation::Quarter => [height - y, x],
            Rotation::Half => [width - x, height - y],
            Rotation::ThreeQuarters => [y, width - x],
        }
    }
}
