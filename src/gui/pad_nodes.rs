//! The regions of the pad for screen readers: children of the pad's node, each with its name, its outputs in words and its state.

use egui::{Id, Role, Sense, Ui, UiBuilder, WidgetInfo};

use super::place::PadTransform;
use super::regions::outputs_of_binding;
use crate::profile::Profile;
use crate::types::Output;

/// Adds a node for every region. They take neither focus nor clicks: the pad's own keys press them.
pub(super) fn add(ui: &mut Ui, pad: Id, place: &PadTransform, profile: &Profile, held: &[Output]) {
    let builder = UiBuilder::new()
        .id_salt("regions of the pad")
        .max_rect(place.rect)
        .accessibility_parent(pad);
    ui.scope_builder(builder, |ui| {
        for (index, region) in profile.regions.iter().enumerate() {
            let (low, high) = region
                .placed(place.seen_mm, &profile.settings.area)
                .bounds_mm();
            let rect =
                egui::Rect::from_two_pos(place.screen_from_seen(low), place.screen_from_seen(high));
            let id = ui.scope_id().with(("region", index));
            let response = ui.interact(rect, id, Sense::hover());
            response.widget_info(|| {
                WidgetInfo::labeled(Role::Label, true, description(profile, index, held))
            });
        }
    });
}

/// Name, outputs and state of a region: `jump, presses key f, held`.
fn description(profile: &Profile, region: usize, held: &[Output]) -> String {
    let mut outputs: Vec<Output> = Vec::new();
    let bindings = profile.bindings.iter();
    for binding in bindings.filter(|binding| binding.regions.contains(&region)) {
        for output in outputs_of_binding(profile, binding) {
            if !outputs.contains(&output) {
                outputs.push(output);
            }
        }
    }
    let name = &profile.regions[region].name;
    if outputs.is_empty() {
        return format!("{name}, presses no key");
    }
    let words: Vec<String> = outputs
        .iter()
        .map(|output| output.to_string().replace(':', " "))
        .collect();
    let is_held = outputs.iter().any(|output| held.contains(output));
    let state = if is_held { "held" } else { "up" };
    format!("{name}, presses {}, {state}", words.join(" and "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::still;

    #[test]
    fn a_region_is_described_in_words() {
        let profile = still::profile();
        let region = |name: &str| {
            let index = profile
                .regions
                .iter()
                .position(|region| region.name == name);
            index.expect("a region")
        };
        let held = ["key:f".parse().expect("a key")];
        let words = |name| description(&profile, region(name), &held);
        assert_eq!(words("jump"), "jump, presses key f, held");
        assert_eq!(words("left"), "left, presses key left, up");
    }
}
