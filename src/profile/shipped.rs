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
pub const SHIPPED_PROFILES: &[ShippedProfile] = shipped!("profiles":
    "super-mario",
    "super-mario-classified",
    "super-mario-nestopia",
    "super-mario-mednafen",
    "super-mario-retroarch",
    "super-mario-gamepad",
    "supertux",
    "falling-blocks",
    "racing",
    "desktop",
    "large-buttons",
    "one-handed",
);

/// Every person's text that is compiled in.
pub const SHIPPED_USERS: &[ShippedProfile] =
    shipped!("users": "tremor", "light-touch", "left-hand");

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{Checked, Mode, Profile, Source, find_shipped, read};

    fn checked(profile: &ShippedProfile, user: Option<&ShippedProfile>) -> Checked {
        let source = |shipped: &ShippedProfile| Source {
            name: shipped.name.to_owned(),
            toml: shipped.toml.to_owned(),
        };
        read(source(profile), user.map(source), &find_shipped)
            .unwrap_or_else(|faulty| panic!("{faulty}"))
    }

    fn plain(name: &str) -> Profile {
        checked(shipped_profile(name).expect("shipped"), None).profile
    }

    #[test]
    fn every_shipped_profile_is_sound_named_as_its_file_and_free_of_warnings() {
        for shipped in SHIPPED_PROFILES {
            let checked = checked(shipped, None);
            assert_eq!(checked.profile.name, shipped.name);
            let warnings: Vec<String> = checked.warnings.iter().map(ToString::to_string).collect();
            assert!(warnings.is_empty(), "{warnings:?}");
            assert!(
                shipped.toml.starts_with("#:schema ./profile.schema.json\n"),
                "{}",
                shipped.name
            );
        }
    }

    #[test]
    fn the_two_super_marios_differ_in_the_jump_alone() {
        let [direct, classified] = ["super-mario", "super-mario-classified"].map(plain);
        assert_eq!(direct.regions, classified.regions);
        assert_eq!(direct.outputs, classified.outputs);
        for (a, b) in direct.bindings.iter().zip(&classified.bindings) {
            let jump = direct.regions[a.regions[0]].name == "jump";
            assert_eq!(a.mode, Mode::Direct);
            assert_eq!(b.mode == Mode::Direct, !jump);
        }
    }

    #[test]
    fn one_handed_holds_everything_of_super_mario_within_half_of_each_side() {
        let [two, one] = ["super-mario", "one-handed"].map(plain);
        assert_eq!(two.outputs, one.outputs);
        for region in &one.regions {
            let (low, high) = region
                .placed([100.0, 100.0], &one.settings.area)
                .bounds_mm();
            assert!(
                low[0] >= 25.0 && low[1] >= 25.0 && high[0] <= 75.0 && high[1] <= 75.0,
                "{}",
                region.name
            );
        }
    }

    #[test]
    fn every_profile_suits_every_user_or_the_warning_names_what_is_out_of_reach() {
        for user in SHIPPED_USERS {
            for profile in SHIPPED_PROFILES {
                let checked = checked(profile, Some(user));
                let settings = &checked.profile.settings;
                let said: String = checked
                    .warnings
                    .iter()
                    .map(|faulty| format!("{faulty}\n"))
                    .collect();
                for (index, region) in checked.profile.regions.iter().enumerate() {
                    let bound = checked
                        .profile
                        .bindings
                        .iter()
                        .any(|binding| binding.regions.contains(&index));
                    let (low, high) = region.placed([1.0, 1.0], &settings.area).bounds_mm();
                    let inside = settings.reachable.is_none_or(|reach| {
                        low[0] >= reach.x - 1e-9
                            && low[1] >= reach.y - 1e-9
                            && high[0] <= reach.x + reach.w + 1e-9
                            && high[1] <= reach.y + reach.h + 1e-9
                    });
                    let told =
                        said.contains(&format!("the region `{}` lies out of reach", region.name));
                    assert_eq!(
                        told,
                        bound && !inside,
                        "{} for {}: {}\n{said}",
                        profile.name,
                        user.name,
                        region.name
                    );
                }
            }
        }
    }
}
