//! What the pad plays: regions, and what a touch in each of them does.
//!
//! A profile is a text (`profiles/*.toml`) that players read, copy and edit. [`Profile::from_toml`] checks all of
//! it and reports every mistake at its word; past that point nothing is optional.

mod region;
mod shipped;
mod spec;

pub use region::{Region, Shape};
pub use shipped::{DEFAULT_PROFILE, SHIPPED_PROFILES, ShippedProfile, shipped_profile};

use crate::types::{Faulty, Method, Nanos, Output, PointMm};

/// How a touch turns into a press.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    /// Down with the touch, up with the touch: length is length.
    Direct,
    /// The paper's short and long press: down with the touch; the time the touch lasts selects one of two lengths.
    Classified(Latch),
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
}

/// What a touch in a region does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Binding {
    /// Index into [`Profile::regions`].
    pub region: usize,
    /// How.
    pub mode: Mode,
    /// Index into [`Profile::outputs`].
    pub output: usize,
}

/// A checked profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Its name.
    pub name: String,
    /// One sentence for lists.
    pub about: String,
    /// How images are made, unless the command line says otherwise; none leaves it to the pad.
    pub method: Option<Method>,
    /// No press is shorter: games that poll would miss it.
    pub min_hold_ns: Nanos,
    /// No release is shorter before the same output is pressed again; zero never delays a press.
    pub min_gap_ns: Nanos,
    /// Regions; where they overlap, the first in the list takes the touch.
    pub regions: Vec<Region>,
    /// Every output that some binding drives, once.
    pub outputs: Vec<Output>,
    /// Bindings in the order of the text.
    pub bindings: Vec<Binding>,
}

impl Profile {
    /// Reads a profile from its text; `name` stands for the file in messages.
    ///
    /// # Errors
    /// Everything that is wrong with the text, each at its place.
    pub fn from_toml(name: &str, text: &str) -> Result<Self, Faulty> {
        spec::read(name, text)
    }

    /// The region that takes a touch at a place on a pad of a size: the first that holds it.
    #[must_use]
    pub fn region_at(&self, point: PointMm, pad_mm: [f64; 2]) -> Option<usize> {
        self.regions
            .iter()
            .position(|region| region.contains(point, pad_mm))
    }
}
