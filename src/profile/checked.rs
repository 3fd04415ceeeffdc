//! A profile that was read and checked.

use super::binding::Binding;
use super::region::Region;
use super::settings::Settings;
use super::sources::Texts;
use crate::types::{GamepadPart, Method, Output, PointMm, SourceErrors};

/// A checked profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Its name.
    pub name: String,
    /// One sentence for lists.
    pub about: String,
    /// The reconstruction, unless the command line names one; none leaves it to the pad.
    pub method: Option<Method>,
    /// Times, accessibility, safety, and the orientation of the pad.
    pub settings: Settings,
    /// Regions, topmost first: where they overlap, the first takes the touch.
    pub regions: Vec<Region>,
    /// Every part of a gamepad or switch that plays a binding, once.
    pub parts: Vec<GamepadPart>,
    /// Every output that a binding drives, once.
    pub outputs: Vec<Output>,
    /// Names of the layers that bindings are on.
    pub layers: Vec<String>,
    /// Bindings in the order of the text.
    pub bindings: Vec<Binding>,
    /// Processes that select this profile while they run (`[match]`).
    pub processes: Vec<String>,
    /// Where each value was written that is not a default.
    pub origins: Vec<Origin>,
    /// The texts that it was read from.
    pub texts: Texts,
}

/// Where a value was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// The key, or `region NAME` or `binding NAME` for a whole table.
    pub key: String,
    /// The value as written; empty for a whole table.
    pub value: String,
    /// Name of the text.
    pub from: String,
}

/// A profile that can be played, and its warnings.
#[derive(Clone, Debug)]
pub struct Checked {
    /// The profile.
    pub profile: Profile,
    /// Warnings, one entry for each text that has any.
    pub warnings: Vec<SourceErrors>,
    /// Names of the texts that it was read from, in the order base, profile, user.
    pub texts: Vec<String>,
}

impl Profile {
    /// The topmost region at a place on a pad of a size, as the player sees the pad.
    #[must_use]
    pub fn region_at(&self, point: PointMm, pad_mm: [f64; 2]) -> Option<usize> {
        self.regions.iter().position(|region| {
            let placed = region.placed(pad_mm, &self.settings.area);
            placed.contains(point, region.reach)
        })
    }
}
