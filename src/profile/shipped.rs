//! The profiles that come with gelpad: compiled in, so that their names work from any folder.

/// Name of the profile that is used when none is asked for.
pub const DEFAULT_PROFILE: &str = "super-mario";

/// A profile that is compiled in.
#[derive(Clone, Copy, Debug)]
pub struct ShippedProfile {
    /// What `gelpad play` takes.
    pub name: &'static str,
    /// Its text.
    pub toml: &'static str,
}

/// Every profile that is compiled in.
pub const SHIPPED_PROFILES: &[ShippedProfile] = &[
    ShippedProfile {
        name: "super-mario",
        toml: include_str!("../../profiles/super-mario.toml"),
    },
    ShippedProfile {
        name: "super-mario-classified",
        toml: include_str!("../../profiles/super-mario-classified.toml"),
    },
];

/// The shipped profile of a name.
#[must_use]
pub fn shipped_profile(name: &str) -> Option<&'static ShippedProfile> {
    SHIPPED_PROFILES.iter().find(|profile| profile.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{Mode, Profile};

    fn read(shipped: &ShippedProfile) -> Profile {
        Profile::from_toml(shipped.name, shipped.toml).expect(shipped.name)
    }

    #[test]
    fn every_shipped_profile_is_sound_and_named_as_its_file() {
        for shipped in SHIPPED_PROFILES {
            assert_eq!(read(shipped).name, shipped.name);
        }
    }

    #[test]
    fn the_two_super_marios_differ_in_the_jump_alone() {
        let [direct, classified] = ["super-mario", "super-mario-classified"]
            .map(|name| read(shipped_profile(name).expect("shipped")));
        assert_eq!(direct.regions, classified.regions);
        assert_eq!(direct.outputs, classified.outputs);
        for (a, b) in direct.bindings.iter().zip(&classified.bindings) {
            let jump = direct.regions[a.region].name == "jump";
            assert_eq!(a.mode, Mode::Direct);
            assert_eq!(b.mode == Mode::Direct, !jump);
        }
    }
}
