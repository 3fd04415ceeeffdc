//! What the pad plays: regions, and what a touch in each of them does.
//!
//! A profile is a text (`profiles/*.toml`) that players read, copy and edit. It may extend another one, and a text about
//! one person (`users/*.toml`) may lie over it. [`read`] checks all of it and reports every mistake at its word; past
//! that point nothing is optional.
//!
//! ```text
//! text ─▶ keys known?  ─▶ merge: base, profile, user ─▶ check ─▶ Profile
//!         (text.rs)       (layers.rs)                   (check/)
//! ```

mod binding;
mod check;
mod describe;
mod keys;
mod layers;
mod region;
mod schema;
mod settings;
mod shipped;
mod text;
mod warn;

pub use binding::{
    Binding, Curve, DeadZone, Direction, Dpad, Flavour, Gains, Gesture, Latch, MacroStep, Mode,
    Pointer, Stick, Swipe, TapHold, Target, Trigger,
};
pub use keys::{Key, Kind, Table, keys};
pub use layers::{MOST_BASES, Source, Texts};
pub use region::{Placed, Region, Shape, Slide};
pub use schema::schema;
pub use settings::{Activate, Area, Assist, Mirror, Rotation, Settings};
pub use shipped::{
    DEFAULT_PROFILE, SHIPPED_PROFILES, SHIPPED_USERS, ShippedProfile, shipped_profile, shipped_user,
};

use crate::types::{Faulty, Method, Output, Part, PointMm};

/// A checked profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Its name.
    pub name: String,
    /// One sentence for lists.
    pub about: String,
    /// How images are made, unless the command line says otherwise; none leaves it to the pad.
    pub method: Option<Method>,
    /// Times, accessibility, safety, and how the pad lies.
    pub settings: Settings,
    /// Regions, topmost first: where they overlap, the first in the list takes the touch.
    pub regions: Vec<Region>,
    /// Every part of a gamepad or switch that some binding is played by, once.
    pub parts: Vec<Part>,
    /// Every output that some binding drives, once.
    pub outputs: Vec<Output>,
    /// Names of the layers that bindings lie on.
    pub layers: Vec<String>,
    /// Bindings in the order of the text.
    pub bindings: Vec<Binding>,
    /// Processes whose running picks this profile (`[match]`).
    pub processes: Vec<String>,
    /// Where each setting that is not the default comes from.
    pub origins: Vec<Origin>,
    /// What it was read from.
    pub texts: Texts,
}

/// Where a value comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// The key, or `region NAME` or `binding N` for a whole table.
    pub key: String,
    /// The value as written; empty for a whole table.
    pub value: String,
    /// Name of the text that it was written in.
    pub from: String,
}

/// A profile that can be played, and what is odd about it.
#[derive(Clone, Debug)]
pub struct Checked {
    /// The profile.
    pub profile: Profile,
    /// Warnings: nothing that keeps it from being played. One entry a text.
    pub warnings: Vec<Faulty>,
    /// Names of the texts that it was read from, in the order base, profile, user.
    pub texts: Vec<String>,
}

/// Finds the text that `extends` names: the shipped profiles first, then whatever the caller adds.
pub type FindBase<'a> = &'a dyn Fn(&str) -> Result<Source, String>;

/// Reads and checks a profile, the bases that it extends, and a person's settings over them.
///
/// # Errors
/// Everything that is wrong, each at its place, in the topmost text that has mistakes.
pub fn read(profile: Source, user: Option<Source>, find: FindBase<'_>) -> Result<Checked, Faulty> {
    check::read(profile, user, find)
}

impl Texts {
    /// Reads them again.
    ///
    /// # Errors
    /// As [`read`].
    pub fn read(&self) -> Result<Checked, Faulty> {
        let (own, bases) = match self.chain.split_last() {
            Some((own, bases)) => (own.clone(), bases),
            None => return Err(Faulty::new("profile", "", vec![])),
        };
        // Each text extends the one below it, by whatever name it had then.
        let left = std::cell::Cell::new(bases);
        let find = |name: &str| match left.get().split_last() {
            Some((base, below)) => {
                left.set(below);
                Ok(base.clone())
            }
            None => Err(format!("the text of `{name}` is missing")),
        };
        read(own, self.user.clone(), &find)
    }
}

impl Profile {
    /// Reads a profile that extends none but shipped ones; `name` stands for the file in messages.
    ///
    /// # Errors
    /// Everything that is wrong with the text, each at its place.
    pub fn from_toml(name: &str, text: &str) -> Result<Self, Faulty> {
        let source = Source {
            name: name.to_owned(),
            toml: text.to_owned(),
        };
        read(source, None, &find_shipped).map(|checked| checked.profile)
    }

    /// The topmost region that holds a place on a pad of a size, as the player sees the pad.
    #[must_use]
    pub fn region_at(&self, point: PointMm, pad_mm: [f64; 2]) -> Option<usize> {
        self.regions.iter().position(|region| {
            let placed = region.placed(pad_mm, &self.settings.area);
            placed.holds(point, region.reach)
        })
    }
}

/// A shipped profile as a base.
///
/// # Errors
/// No such profile; the message says what to do.
pub fn find_shipped(name: &str) -> Result<Source, String> {
    match shipped_profile(name) {
        Some(shipped) => Ok(Source {
            name: shipped.name.to_owned(),
            toml: shipped.toml.to_owned(),
        }),
        None => Err(format!("no shipped profile is named `{name}`")),
    }
}
