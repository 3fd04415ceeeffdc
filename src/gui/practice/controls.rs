//! What a profile's outputs mean in the level.

use crate::profile::{Profile, Target};
use crate::types::{Axis, Output};

/// An axis counts as held beyond this.
const AXIS_HELD: f32 = 0.4;
/// Regions whose output jumps or runs, whatever it is, ...
const JUMP_REGIONS: &[&str] = &["jump", "a"];
const RUN_REGIONS: &[&str] = &["run", "b", "action"];
/// ... and outputs that do in games, the likeliest first.
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

/// What an output does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deed {
    /// Towards the start.
    Left,
    /// Towards the end.
    Right,
    /// Faster.
    Run,
    /// Up.
    Jump,
}

/// The outputs that do something.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Controls {
    deeds: Vec<(Output, Deed)>,
    /// Names of the first region whose output does it.
    regions: Vec<(Deed, String)>,
}

impl Controls {
    /// What a profile's outputs do: by the name of their region, else by what they do in most games.
    #[must_use]
    pub fn of(profile: &Profile) -> Self {
        let mut controls = Self::default();
        for binding in &profile.bindings {
            let named = |names: &[&str]| {
                binding
                    .regions
                    .iter()
                    .any(|region| names.contains(&profile.regions[*region].name.as_str()))
            };
            let deed = if named(JUMP_REGIONS) {
                Deed::Jump
            } else if named(RUN_REGIONS) {
                Deed::Run
            } else {
                continue;
            };
            for target in &binding.targets {
                if let Target::Output(index) = target {
                    controls.add(profile.outputs[*index], deed);
                }
            }
        }
        for (names, deed) in [
            (LEFT_OUTPUTS, Deed::Left),
            (RIGHT_OUTPUTS, Deed::Right),
            (JUMP_OUTPUTS, Deed::Jump),
        ] {
            for name in names {
                let listed = profile
                    .outputs
                    .iter()
                    .find(|output| output.to_string() == *name);
                if let Some(output) = listed
                    && controls.output(deed).is_none()
                {
                    controls.add(*output, deed);
                }
            }
        }
        controls.name_regions(profile);
        controls
    }

    fn name_regions(&mut self, profile: &Profile) {
        for binding in &profile.bindings {
            let deed = binding.targets.iter().find_map(|target| match target {
                Target::Output(index) => self.deed(profile.outputs[*index]),
                _ => None,
            });
            if let (Some(deed), Some(region)) = (deed, binding.regions.first())
                && self.region(deed).is_none()
            {
                let name = profile.regions[*region].name.clone();
                self.regions.push((deed, name));
            }
        }
    }

    /// What the player presses for it: the region's name, else the output's.
    #[must_use]
    pub fn told(&self, deed: Deed) -> Option<String> {
        let region = self.region(deed).map(str::to_owned);
        region.or_else(|| self.output(deed).map(|output| output.to_string()))
    }

    fn region(&self, deed: Deed) -> Option<&str> {
        let found = self.regions.iter().find(|(other, _)| *other == deed);
        found.map(|(_, name)| name.as_str())
    }

    fn add(&mut self, output: Output, deed: Deed) {
        if self.deed(output).is_none() {
            self.deeds.push((output, deed));
        }
    }

    /// What an output does.
    #[must_use]
    pub fn deed(&self, output: Output) -> Option<Deed> {
        let found = self.deeds.iter().find(|(other, _)| *other == output);
        found.map(|(_, deed)| *deed)
    }

    /// The first output that does something.
    #[must_use]
    pub fn output(&self, deed: Deed) -> Option<Output> {
        let found = self.deeds.iter().find(|(_, other)| *other == deed);
        found.map(|(output, _)| *output)
    }

    /// What a value of an axis holds: left, right.
    #[must_use]
    pub fn axis(axis: Axis, value: f32) -> Option<[bool; 2]> {
        (axis == Axis::LeftX).then_some([value < -AXIS_HELD, value > AXIS_HELD])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::SHIPPED_PROFILES;

    #[test]
    fn most_shipped_profiles_can_walk_right_and_jump() {
        let playable: Vec<&str> = SHIPPED_PROFILES
            .iter()
            .filter(|shipped| {
                let profile = Profile::from_toml(shipped.name, shipped.toml).expect("sound");
                let controls = Controls::of(&profile);
                controls.output(Deed::Right).is_some() && controls.output(Deed::Jump).is_some()
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
    fn super_mario_jumps_and_runs_by_its_regions() {
        let shipped = SHIPPED_PROFILES
            .iter()
            .find(|shipped| shipped.name == "super-mario")
            .expect("shipped");
        let profile = Profile::from_toml(shipped.name, shipped.toml).expect("sound");
        let controls = Controls::of(&profile);
        let deed = |name: &str| controls.deed(name.parse().expect("an output"));
        assert_eq!(deed("key:f"), Some(Deed::Jump));
        assert_eq!(deed("key:d"), Some(Deed::Run));
        assert_eq!(deed("key:left"), Some(Deed::Left));
        assert_eq!(deed("key:down"), None);
    }
}
