//! What the pad plays: regions, and what a touch in each of them does.
//!
//! A profile is a TOML text (`profiles/*.toml`) that players read, copy and edit. It may extend another one, and user
//! settings (`users/*.toml`) may be put over it. [`read`] checks everything and reports each mistake at its place;
//! a checked profile has no unresolved values.
//!
//! ```text
//! text ─▶ keys known? ─▶ merge: base, profile, user ─▶ check ─▶ Profile
//!         (text.rs)      (layers.rs)                   (check/)
//! ```

mod binding;
mod check;
mod checked;
mod describe;
mod diagnostics;
mod entries;
pub(crate) mod gestures;
mod key_list;
mod keys;
mod layers;
mod reader;
mod region;
mod schema;
mod settings;
mod shipped;
mod sources;
mod target;
mod targets;
mod text;
mod warn;

pub use binding::{Binding, Latch, MacroStep, Mode};
pub use check::read;
pub use checked::{Checked, Origin, Profile};
pub use gestures::*;
pub use key_list::keys;
pub use keys::{Fallback, Key, KeyKind, Table};
pub use layers::MAX_BASES;
pub use region::{PlacedRegion, Region, Shape, Slide};
pub use schema::schema;
pub use settings::{Activate, Area, Assist, Mirror, Rotation, Settings};
pub use shipped::{
    DEFAULT_PROFILE, SHIPPED_PROFILES, SHIPPED_USERS, ShippedProfile, find_shipped,
    shipped_profile, shipped_user,
};
pub use sources::{FindBase, Source, Texts};
pub use target::Target;
