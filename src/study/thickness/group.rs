//! The touches of a thickness study, grouped by kind.

use super::{Case, Thickness, ThicknessOutcome, Touch, TouchResult};
use crate::stats::{mean, range};

/// A kind of touch at one depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Kind {
    touch: Touch,
    /// 0 where the depth is a share.
    depth_mm: f64,
    share: Option<f64>,
}

impl Kind {
    fn new(case: &Case, result: &TouchResult) -> Self {
        Self {
            touch: case.touch,
            // The depth in mm of a share differs between thicknesses.
            depth_mm: result.share.map_or(result.depth_mm, |_| 0.0),
            share: result.share,
        }
    }

    pub(super) fn name(self) -> String {
        match (self.touch, self.share) {
            (Touch::Rise, _) => self.touch.name().to_owned(),
            (touch, Some(share)) => format!("{} %, {}", 100.0 * share, touch.name()),
            (touch, None) => format!("{} mm, {}", self.depth_mm, touch.name()),
        }
    }
}

/// All touches of one kind, by thickness, then by place.
pub(super) struct Group<'a> {
    pub(super) kind: Kind,
    results: Vec<(&'a Case, &'a TouchResult)>,
}

impl Group<'_> {
    /// Mean, least and greatest value over the places at one thickness; `None` without touches there.
    pub(super) fn at(
        &self,
        layer_mm: f64,
        figure: impl Fn(&TouchResult) -> f64,
    ) -> Option<[f64; 3]> {
        let results = self
            .results
            .iter()
            .filter(|(case, _)| case.layer_mm == layer_mm);
        let values: Vec<f64> = results.map(|(_, result)| figure(result)).collect();
        let [least, most] = range(values.iter().copied());
        (!values.is_empty()).then(|| [mean(values), least, most])
    }

    /// The greatest mean over the least mean of all thicknesses.
    pub(super) fn factor(&self, layers_mm: &[f64], figure: impl Fn(&TouchResult) -> f64) -> f64 {
        let layers = layers_mm
            .iter()
            .filter_map(|layer| self.at(*layer, &figure));
        let [least, most] = range(layers.map(|[mean, ..]| mean));
        most / least
    }

    /// The greatest over the least value of all places, mean over the thicknesses.
    pub(super) fn factor_of_place(
        &self,
        layers_mm: &[f64],
        figure: impl Fn(&TouchResult) -> f64,
    ) -> f64 {
        let layers = layers_mm
            .iter()
            .filter_map(|layer| self.at(*layer, &figure));
        mean(layers.map(|[_, least, most]| most / least))
    }
}

impl Thickness {
    /// The touches by kind.
    pub(super) fn groups<'a>(&'a self, outcomes: &'a [ThicknessOutcome]) -> Vec<Group<'a>> {
        let mut groups: Vec<Group<'a>> = Vec::new();
        let usual = self
            .cases
            .iter()
            .zip(outcomes)
            .filter(|(case, _)| case.finer == 1.0);
        for (case, result) in
            usual.flat_map(|(case, one)| one.pressed.iter().map(move |p| (case, p)))
        {
            let kind = Kind::new(case, result);
            match groups.iter_mut().find(|group| group.kind == kind) {
                Some(group) => group.results.push((case, result)),
                None => groups.push(Group {
                    kind,
                    results: vec![(case, result)],
                }),
            }
        }
        groups.sort_by_key(|group| {
            Touch::ALL
                .iter()
                .position(|touch| *touch == group.kind.touch)
        });
        groups
    }
}
