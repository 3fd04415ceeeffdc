//! Outputs of the regions of a profile, and whether they are held.

use crate::profile::{Binding, Gesture, Profile, Target};
use crate::types::Output;

/// The outputs of a region.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RegionState {
    /// Labels of its outputs, such as `F` or `←`, separated by spaces.
    pub outputs: String,
    /// Whether any of them is held.
    pub held: bool,
}

/// The state of every region of a profile.
pub fn region_states(profile: &Profile, held: &[Output]) -> Vec<RegionState> {
    let state = |region: usize| {
        let mut all_labels: Vec<String> = Vec::new();
        let mut is_held = false;
        let bindings = profile.bindings.iter();
        for binding in bindings.filter(|binding| binding.regions.contains(&region)) {
            for label in labels(profile, binding) {
                if !all_labels.contains(&label) {
                    all_labels.push(label);
                }
            }
            is_held |= outputs_of_binding(profile, binding).any(|output| held.contains(&output));
        }
        RegionState {
            outputs: all_labels.join(" "),
            held: is_held,
        }
    };
    (0..profile.regions.len()).map(state).collect()
}

/// What a plain press of a region sends, such as `F`: no layers, chords or holds. Empty for a region that sends nothing so.
pub fn press_outputs(profile: &Profile, region: &str) -> String {
    let is_of_region = |binding: &&Binding| {
        let mut regions = binding.regions.iter();
        matches!(binding.gesture, Gesture::Press(_))
            && binding.layer.is_none()
            && regions.any(|index| profile.regions[*index].name == region)
    };
    let bindings = profile.bindings.iter().filter(is_of_region);
    let mut all: Vec<String> = bindings
        .flat_map(|binding| labels(profile, binding))
        .collect();
    all.dedup();
    all.join(" ")
}

/// What players call a region: its name, or for a cell of a grid its outputs.
pub fn region_title(profile: &Profile, index: usize) -> String {
    let region = &profile.regions[index];
    if region.is_cell {
        let outputs = press_outputs(profile, &region.name);
        if !outputs.is_empty() {
            return outputs;
        }
    }
    region.name.clone()
}

/// The outputs of a binding.
pub fn outputs_of_binding<'a>(
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

fn labels(profile: &Profile, binding: &Binding) -> Vec<String> {
    let outputs: Vec<String> = outputs_of_binding(profile, binding)
        .map(output_label)
        .collect();
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

/// The label of an output, as on a keycap: `F`, `←`, `A`, `mouse left`.
pub fn output_label(output: Output) -> String {
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
        let states = region_states(&profile, &held);
        for (region, state) in profile.regions.iter().zip(&states) {
            assert_eq!(state.held, region.name == "jump", "{}", region.name);
        }
        let left = profile.regions.iter().position(|r| r.name == "left");
        assert_eq!(states[left.expect("a region")].outputs, "←");
    }

    #[test]
    fn a_plain_press_sends_what_no_layer_or_chord_adds() {
        let text = r#"
            schema = 1
            name = "two"
            region = [{ name = "a", x = 0.0, y = 0.0, w = 0.5, h = 1.0 }, { name = "b", x = 0.5, y = 0.0, w = 0.5, h = 1.0 }]
            binding = [
                { region = "a", output = "key:f" },
                { region = "a", layer = "other", output = "key:g" },
                { region = ["a", "b"], gesture = "chord", output = "key:h" },
                { region = "b", gesture = "tap", output = "layer:other" },
            ]
        "#;
        let profile = Profile::from_toml("two", text).unwrap_or_else(|faulty| panic!("{faulty}"));
        assert_eq!(press_outputs(&profile, "a"), "F");
        assert_eq!(press_outputs(&profile, "b"), "");
    }

    #[test]
    fn a_cell_of_a_grid_is_called_by_its_outputs() {
        let shipped = crate::profile::SHIPPED_PROFILES.iter();
        let large = shipped.filter(|shipped| shipped.name == "large-buttons");
        let profiles: Vec<Profile> = large
            .map(|shipped| Profile::from_toml(shipped.name, shipped.toml).expect("sound"))
            .collect();
        let titles: Vec<String> = (0..4).map(|i| region_title(&profiles[0], i)).collect();
        assert_eq!(titles, ["←", "→", "enter", "space"]);
        let mario = still::profile();
        assert_eq!(region_title(&mario, 0), mario.regions[0].name);
    }

    #[test]
    fn every_bound_region_of_the_shipped_profiles_has_a_label() {
        for shipped in crate::profile::SHIPPED_PROFILES {
            let profile = Profile::from_toml(shipped.name, shipped.toml).expect("sound");
            for (index, state) in region_states(&profile, &[]).iter().enumerate() {
                let bound = profile.bindings.iter().any(|binding| {
                    binding.regions.contains(&index)
                        && outputs_of_binding(&profile, binding).next().is_some()
                });
                assert_eq!(state.outputs.is_empty(), !bound && state.outputs.is_empty());
                assert!(!bound || !state.outputs.is_empty());
            }
        }
    }
}
