//! Maps the outputs of a profile to actions in the level.

use crate::gui::regions::region_title;
use crate::profile::{Profile, Target};
use crate::types::{Axis, Output};

/// An axis beyond this value counts as held.
const AXIS_HELD: f32 = 0.4;
/// Names of regions that jump or run whatever their output is.
const JUMP_REGIONS: &[&str] = &["jump", "a"];
const RUN_REGIONS: &[&str] = &["run", "b", "action"];
/// Outputs that jump, walk left or walk right in most games, the most common first.
const JUMP_OUTPUTS: &[&str] = &[
    "pad:south",
    "key:space",
    "key:f",
    "key:x",
    "key:z",
    "key:up",
    "pad:east",
    "key:enter",
];
const LEFT_OUTPUTS: &[&str] = &["key:left", "pad:left", "key:a"];
const RIGHT_OUTPUTS: &[&str] = &["key:right", "pad:right", "key:d"];

/// An action of the player in the level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum GameAction {
    /// Walks towards the start.
    Left,
    /// Walks towards the flag.
    Right,
    /// Runs instead of walking.
    Run,
    /// Jumps.
    Jump,
}

/// The outputs of a profile that act in the level.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Controls {
    outputs: Vec<(Output, GameAction)>,
    /// For each action, the first region bound to it.
    regions: Vec<(GameAction, String)>,
}

impl Controls {
    /// Assigns actions by the names of regions, then by what outputs do in most games.
    pub(super) fn from_profile(profile: &Profile) -> Self {
        let mut controls = Self::default();
        for binding in &profile.bindings {
            let named = |names: &[&str]| {
                binding
                    .regions
                    .iter()
                    .any(|region| names.contains(&profile.regions[*region].name.as_str()))
            };
            let action = if named(JUMP_REGIONS) {
                GameAction::Jump
            } else if named(RUN_REGIONS) {
                GameAction::Run
            } else {
                continue;
            };
            for target in &binding.targets {
                if let Target::Output(index) = target {
                    controls.add(profile.outputs[*index], action);
                }
            }
        }
        for (names, action) in [
            (LEFT_OUTPUTS, GameAction::Left),
            (RIGHT_OUTPUTS, GameAction::Right),
            (JUMP_OUTPUTS, GameAction::Jump),
        ] {
            for name in names {
                let listed = profile
                    .outputs
                    .iter()
                    .find(|output| output.to_string() == *name);
                if let Some(output) = listed
                    && controls.output(action).is_none()
                {
                    controls.add(*output, action);
                }
            }
        }
        controls.name_regions(profile);
        controls
    }

    fn name_regions(&mut self, profile: &Profile) {
        for binding in &profile.bindings {
            let action = binding.targets.iter().find_map(|target| match target {
                Target::Output(index) => self.action(profile.outputs[*index]),
                _ => None,
            });
            if let (Some(action), Some(region)) = (action, binding.regions.first())
                && self.region(action).is_none()
            {
                self.regions.push((action, region_title(profile, *region)));
            }
        }
    }

    /// What the player presses for an action: the name of a region, else of an output.
    pub(super) fn label(&self, action: GameAction) -> Option<String> {
        let region = self.region(action).map(str::to_owned);
        region.or_else(|| self.output(action).map(|output| output.to_string()))
    }

    fn region(&self, action: GameAction) -> Option<&str> {
        let found = self.regions.iter().find(|(other, _)| *other == action);
        found.map(|(_, name)| name.as_str())
    }

    fn add(&mut self, output: Output, action: GameAction) {
        if self.action(output).is_none() {
            self.outputs.push((output, action));
        }
    }

    /// The action of an output.
    pub(super) fn action(&self, output: Output) -> Option<GameAction> {
        let found = self.outputs.iter().find(|(other, _)| *other == output);
        found.map(|(_, action)| *action)
    }

    /// The first output of an action.
    pub(super) fn output(&self, action: GameAction) -> Option<Output> {
        let found = self.outputs.iter().find(|(_, other)| *other == action);
        found.map(|(output, _)| *output)
    }

    /// Whether a value of an axis holds left and right; `None` for axes that do not walk.
    pub(super) fn held_by_axis(axis: Axis, value: f32) -> Option<[bool; 2]> {
        (axis == Axis::LeftX).then_some([value < -AXIS_HELD, value > AXIS_HELD])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::SHIPPED_PROFILES;

    #[test]
    fn shipped_platform_profiles_walk_and_jump() {
        let playable: Vec<&str> = SHIPPED_PROFILES
            .iter()
            .filter(|shipped| {
                let profile = Profile::from_toml(shipped.name, shipped.toml).expect("valid");
                let controls = Controls::from_profile(&profile);
                controls.output(GameAction::Right).is_some()
                    && controls.output(GameAction::Jump).is_some()
            })
            .map(|shipped| shipped.name)
            .collect();
        for name in [
            "super-mario",
            "super-mario-classified",
            "supertux",
            "large-buttons",
            "one-handed",
        ] {
            assert!(playable.contains(&name), "{name}: {playable:?}");
        }
    }

    #[test]
    fn actions_follow_the_names_of_regions() {
        let shipped = SHIPPED_PROFILES
            .iter()
            .find(|shipped| shipped.name == "super-mario")
            .expect("shipped");
        let profile = Profile::from_toml(shipped.name, shipped.toml).expect("valid");
        let controls = Controls::from_profile(&profile);
        let action = |name: &str| controls.action(name.parse().expect("an output"));
        assert_eq!(action("key:f"), Some(GameAction::Jump));
        assert_eq!(action("key:d"), Some(GameAction::Run));
        assert_eq!(action("key:left"), Some(GameAction::Left));
        assert_eq!(action("key:down"), None);
    }
}
