//! Shipped profiles and user settings: compiled in, so that their names work from any folder.

use super::sources::Source;

/// The profile that is played when none is named.
pub const DEFAULT_PROFILE: &str = "super-mario";

/// A profile, or user settings, that is compiled in.
#[derive(Clone, Copy, Debug)]
pub struct ShippedProfile {
    /// Its name on the command line.
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

/// All profiles that are compiled in.
pub const SHIPPED_PROFILES: &[ShippedProfile] = shipped!("profiles":
    "super-mario",
    "large-buttons",
    "one-handed",
    "super-mario-classified",
    "super-mario-nestopia",
    "super-mario-mednafen",
    "super-mario-retroarch",
    "super-mario-gamepad",
    "supertux",
    "falling-blocks",
    "racing",
    "desktop",
);

/// All user settings that are compiled in.
pub const SHIPPED_USERS: &[ShippedProfile] =
    shipped!("users": "tremor", "light-touch", "left-hand");

/// The shipped profile of a name.
#[must_use]
pub fn shipped_profile(name: &str) -> Option<&'static ShippedProfile> {
    SHIPPED_PROFILES.iter().find(|profile| profile.name == name)
}

/// The shipped user settings of a name.
#[must_use]
pub fn shipped_user(name: &str) -> Option<&'static ShippedProfile> {
    SHIPPED_USERS.iter().find(|user| user.name == name)
}

/// A shipped profile as a base.
///
/// # Errors
/// There is no such profile.
pub fn find_shipped(name: &str) -> Result<Source, String> {
    match shipped_profile(name) {
        Some(shipped) => Ok(Source {
            name: shipped.name.to_owned(),
            toml: shipped.toml.to_owned(),
        }),
        None => Err(format!("no shipped profile is named `{name}`")),
    }
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
            .unwrap_or_else(|errors| panic!("{errors}"))
    }

    fn plain(name: &str) -> Profile {
        checked(shipped_profile(name).expect("shipped"), None).profile
    }

    #[test]
    fn shipped_profiles_are_valid_and_have_no_warnings() {
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
    fn super_mario_and_its_classified_form_differ_only_in_jump() {
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
    fn one_handed_fits_super_mario_into_half_of_each_side() {
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
    fn a_warning_names_each_region_out_of_reach() {
        for user in SHIPPED_USERS {
            for profile in SHIPPED_PROFILES {
                let checked = checked(profile, Some(user));
                let settings = &checked.profile.settings;
                let warnings: String = checked
                    .warnings
                    .iter()
                    .map(|errors| format!("{errors}\n"))
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
                    let warned =
                        warnings.contains(&format!("the region `{}` is out of reach", region.name));
                    assert_eq!(
                        warned,
                        bound && !inside,
                        "{} for {}: {}\n{warnings}",
                        profile.name,
                        user.name,
                        region.name
                    );
                }
            }
        }
    }
}
