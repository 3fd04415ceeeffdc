//! The profiles that come with gelpad, and texts about people to begin with: compiled in, so that their names work
//! from any folder.

/// Name of the profile that is used when none is asked for.
pub const DEFAULT_PROFILE: &str = "super-mario";

/// A profile, or a person's text, that is compiled in.
#[derive(Clone, Copy, Debug)]
pub struct ShippedProfile {
    /// What `gelpad play` takes.
    pub name: &'static str,
    /// Its text.
    pub toml: &'static str,
}

macro_rules! shipped {
    ($folder:literal: $($name:literal),+ $(,)?) => {
        &[$(ShippedProfile {
            name: $name,
            toml: include_str!(concat!("../../", $folder, "/", $name, ".toml")),
        }),+]
    };
}

/// Every profile that is compiled in.
pub const SHIPPED_PROFILES: &[ShippedProfile] =
    shipped!("profiles": "super-mario", "super-mario-classified");

/// Every person's text that is compiled in.
pub const SHIPPED_USERS: &[ShippedProfile] = &[];

/// The shipped profile of a name.
#[must_use]
pub fn shipped_profile(name: &str) -> Option<&'static ShippedProfile> {
    SHIPPED_PROFILES.iter().find(|profile| profile.name == name)
}

/// The shipped text about a person.
#[must_use]
pub fn shipped_user(name: &str) -> Option<&'static ShippedProfile> {
    SHIPPED_USERS.iter().find(|user| user.name == name)
}
