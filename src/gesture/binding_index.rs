//! Which bindings a touch may concern: found once, not at every step.

use super::recognizers;
use crate::profile::Profile;

/// Indices of bindings by where they are played.
#[derive(Clone, Debug)]
pub(super) struct BindingIndex {
    /// By place: gestures of one touch.
    pub by_place: Vec<Vec<usize>>,
    /// Gestures of one touch anywhere on the pad.
    pub whole_pad: Vec<usize>,
    /// Gestures that several touches make together.
    pub groups: Vec<usize>,
    /// The places of each binding: the indices of regions, and after these the parts of gamepads.
    pub places: Vec<Vec<usize>>,
}

impl BindingIndex {
    pub(super) fn new(profile: &Profile) -> Self {
        let region_count = profile.regions.len();
        let places: Vec<Vec<usize>> = profile
            .bindings
            .iter()
            .map(|binding| {
                let parts = binding.parts.iter().map(|part| region_count + part);
                binding.regions.iter().copied().chain(parts).collect()
            })
            .collect();
        let is_group = |index: &usize| recognizers::is_group(&profile.bindings[*index].gesture);
        let (groups, singles): (Vec<usize>, Vec<usize>) = (0..places.len()).partition(is_group);
        let at_place = |place: usize| {
            let played = singles.iter().copied();
            played
                .filter(|index| places[*index].contains(&place))
                .collect()
        };
        Self {
            by_place: (0..region_count + profile.parts.len())
                .map(at_place)
                .collect(),
            whole_pad: singles
                .iter()
                .copied()
                .filter(|index| places[*index].is_empty())
                .collect(),
            groups,
            places,
        }
    }
}
