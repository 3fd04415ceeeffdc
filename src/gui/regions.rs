//! What the regions of a profile do, and whether they do it now. Pure.

use crate::profile::{Binding, Gesture, Profile, Target};
use crate::types::Output;

/// A region's state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RegionState {
    /// What it drives, short: `f`, `A`, `left`.
    pub drives: String,
    /// Whether any of it is held.
    pub held: bool,
}

/// The state of every region of a profile.
#[must_use]
pub fn states(profile: &Profile, held: &[Output]) -> Vec<RegionState> {
    (0..profile.regions.len())
        .map(|region| {
            let bindings = || {
                profile
                    .bindings
                    .iter()
                    .filter(move |binding| binding.regions.contains(&region))
            };
            let mut drives: Vec<String> = Vec::new();
            for binding in bindings() {
                for name in names(profile, binding) {
                    if !drives.contains(&name) {
                        drives.push(name);
                    }
                }
            }
            RegionState {
                drives: drives.join(" "),
                held: bindings()
                    .flat_map(|binding| outputs(profile, binding))
                    .any(|output| held.contains(&output)),
            }
        })
        .collect()
}

/// Outputs that a binding drives.
pub fn outputs<'a>(
    profile: &'a Profile,
    binding: &'a Binding,
) -> impl Iterator<Item = Output> + 'a {
    let directions = match &binding.gesture {
        Gesture::Dpad(dpad) => dpad.targets.as_slice(),
        _ => &[],
    };
    let held = match &binding.gesture {
        Gesture::TapHold(tap_hold) => tap_hold.hold.as_slice(),
        _ => &[],
    };
    binding
        .targets
        .iter()
        .chain(directions.iter().flatten())
        .chain(held)
        .filter_map(|target| match target {
            Target::Output(index) => profile.outputs.get(*index).copied(),
            _ => None,
        })
}

fn names(profile: &Profile, binding: &Binding) -> Vec<String> {
    let outputs: Vec<String> = outputs(profile, binding).map(short).collect();
    if !outputs.is_empty() {
        return outputs;
    }
    match &binding.gesture {
        Gesture::Stick(_) => vec!["stick".to_owned()],
        Gesture::Trigger(trigger) => vec![trigger.axis.to_string()],
        Gesture::Pointer(pointer) if pointer.wheel => vec!["wheel".to_owned()],
        Gesture::Pointer(_) => vec!["pointer".to_owned()],
        _ => Vec::new(),
    }
}

/// An output as a cap would name it.
#[must_use]
pub fn short(output: Output) -> String {
    match output {
        Output::Key(key) => match key.to_string().as_str() {
            "left" => "←".to_owned(),
            "right" => "→".to_owned(),
            "up" => "↑".to_owned(),
            "down" => "↓".to_owned(),
            name if name.chars().count() == 1 => name.to_uppercase(),
            name => name.to_owned(),
        },
        Output::Button(button) => match button.to_string() {
            name if name.chars().count() == 1 => name.to_uppercase(),
            name => name,
        },
        Output::Mouse(button) => format!("mouse {button}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::still;

    #[test]
    fn a_region_is_held_while_one_of_its_outputs_is() {
        let profile = still::profile();
        let held = ["key:f".parse().expect("a key")];
        let states = states(&profile, &held);
        for (region, state) in profile.regions.iter().zip(&states) {
            assert_eq!(state.held, region.name == "jump", "{}", region.name);
        }
        let left = profile.regions.iter().position(|r| r.name == "left");
        assert_eq!(states[left.expect("a region")].drives, "←");
    }

    #[test]
    fn every_shipped_profile_names_what_its_bound_regions_drive() {
        for shipped in crate::profile::SHIPPED_PROFILES {
            let profile = Profile::from_toml(shipped.name, shipped.toml).expect("sound");
            for (index, state) in states(&profile, &[]).iter().enumerate() {
                let bound = profile.bindings.iter().any(|binding| {
                    binding.regions.contains(&index) && outputs(&profile, binding).next().is_some()
                });
                assert_eq!(state.drives.is_empty(), !bound && state.drives.is_empty());
                assert!(!bound || !state.drives.is_empty());
            }
        }
    }
}
