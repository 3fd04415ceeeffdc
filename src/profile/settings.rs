//! What holds for a whole profile: times, accessibility, safety, and how the pad lies.

use crate::types::{Nanos, PointMm};

/// When a touch acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activate {
    /// At once.
    Down,
    /// When it lifts, if it has not left its region: sliding off takes it back.
    Up,
}

/// Which place of a touch counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Assist {
    /// Every place, as it moves.
    Off,
    /// The one where it went down.
    First,
    /// The one where it lifts; it acts then.
    Last,
}

/// The pad seen in a mirror.
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

/// The pad turned, counter-clockwise as the player sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rotation {
    /// As it is.
    None,
    /// A quarter to the left: the pad's right edge is the player's top.
    Quarter,
    /// Upside down.
    Half,
    /// A quarter to the right.
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

/// Settings, checked. Times that switch something off are zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// No press is shorter: games that poll would miss it.
    pub min_hold_ns: Nanos,
    /// No release is shorter before the same output is pressed again; zero never delays a press.
    pub min_gap_ns: Nanos,
    /// A longer press is released by force, if set.
    pub max_hold_ns: Option<Nanos>,
    /// SlowKeys: a touch counts only after it was held this long.
    pub slow_keys_ns: Nanos,
    /// BounceKeys: a re-press of a region sooner than this after its last accepted release is ignored.
    pub bounce_keys_ns: Nanos,
    /// A touch counts when it has stayed in one place this long.
    pub dwell_ns: Nanos,
    /// What one place is for `dwell_ns`.
    pub dwell_mm: f64,
    /// Moves smaller than this are not seen; a finger that comes back within it is the same touch.
    pub tremor_mm: f64,
    /// A finger that comes back sooner than this has not lifted.
    pub tremor_ns: Nanos,
    /// When a touch acts.
    pub activate: Activate,
    /// Which place counts.
    pub assist: Assist,
    /// A contact of more than this gives nothing, mm2.
    pub rest_area_mm2: Option<f64>,
    /// So many contacts at once release everything and pause.
    pub panic_contacts: Option<usize>,
    /// Force that counts as none, and as full: this person's range.
    pub force_range: [f64; 2],
    /// The pad in a mirror.
    pub mirror: Mirror,
    /// The pad turned; after the mirror.
    pub rotate: Rotation,
    /// Where the profile's regions lie: their 0..1 is this part of the pad.
    pub area: Area,
    /// What the person can reach, if told.
    pub reachable: Option<Area>,
}

impl Settings {
    /// The pad's size (width, height) as the player sees it.
    #[must_use]
    pub fn seen_size_mm(&self, [width, height]: [f64; 2]) -> [f64; 2] {
        match self.rotate {
            Rotation::None | Rotation::Half => [width, height],
            Rotation::Quarter | Rotation::ThreeQuarters => [height, width],
        }
    }

    /// A place on a pad of a size, where the player sees it.
    #[must_use]
    pub fn seen(&self, [x, y]: PointMm, [width, height]: [f64; 2]) -> PointMm {
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
