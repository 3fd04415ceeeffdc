//! The tables of the width study.

use super::{Change, LEVELS, RankCriterion, TOUCH_MM, Width, WidthOutcome};
use crate::study::Phantom;
use crate::study::figure::short;
use crate::study::report::Table;
use crate::types::PointMm;

/// Columns of a [`Change`].
const CHANGE: [&str; 4] = [
    "mean_abs_dv_v_per_a_2d",
    "mean_abs_dv_over_v",
    "rms_dv_over_noise_60db",
    "rms_dv_over_full_scale_noise_60db",
];

impl Width {
    /// Indices of the variants, best first.
    pub(super) fn ranking(&self, outcomes: &[WidthOutcome]) -> Vec<usize> {
        let key = |index: &usize| -> f64 {
            let one = &outcomes[*index];
            match self.settings.rank {
                RankCriterion::Change => -one.over_places(|change| change.absolute)[0],
                RankCriterion::Relative => -one.over_places(|change| change.relative)[0],
                RankCriterion::Bound => one.bound_mm()[0],
            }
        };
        let mut order: Vec<usize> = (0..outcomes.len()).collect();
        order.sort_by(|a, b| key(a).total_cmp(&key(b)));
        order
    }

    pub(super) fn summary(&self, outcomes: &[WidthOutcome]) -> Table {
        let top = LEVELS.len() - 1;
        let rows = self.ranking(outcomes).into_iter().map(|index| {
            let one = &outcomes[index];
            let places = |figure: fn(&Change) -> f64| one.over_places(figure)[0];
            let figures = [
                one.bound_mm()[0],
                1e3 * places(|change| change.absolute),
                100.0 * places(|change| change.relative),
                places(|change| change.over_proportional_noise),
                1e3 * one.mean_of_phantoms(top, |change| change.absolute),
                100.0 * one.mean_of_phantoms(top, |change| change.relative),
            ];
            let label = self.variants[index].label.clone();
            std::iter::once(label).chain(figures.map(short)).collect()
        });
        let head = [
            self.parameter(),
            "place bound, mm",
            "|dV|, mV/A",
            "|dV/V|, %",
            "dV / noise",
            "phantoms: |dV|, mV/A",
            "phantoms: |dV/V|, %",
        ];
        Table::new(
            format!("Best first, by {}", self.settings.rank.name()),
            &head,
            rows,
        )
    }

    pub(super) fn csvs(&self, outcomes: &[WidthOutcome]) -> Vec<Table> {
        let found = || self.variants.iter().zip(outcomes);
        let phantoms = found().flat_map(|(variant, one)| {
            let names = Phantom::points(TOUCH_MM).map(|phantom| phantom.name);
            let levels = names
                .into_iter()
                .flat_map(|name| LEVELS.map(|level| (name, level)));
            levels.zip(&one.phantoms).map(|((name, level), change)| {
                cells(
                    [variant.label.clone(), name.to_owned(), level.to_string()],
                    change,
                )
            })
        });
        let places = found().flat_map(|(variant, one)| {
            let places = self.places.iter().zip(&one.places);
            places.map(|(place, change)| cells(at(&variant.label, place), change))
        });
        let bounds = found().flat_map(|(variant, one)| {
            one.bounds.iter().map(|(place, bound)| {
                let [label, x, y] = at(&variant.label, place);
                vec![label, x, y, bound.to_string()]
            })
        });
        let head = |first: [&'static str; 3]| [&first[..], &CHANGE[..]].concat();
        let place = ["variant", "x_mm", "y_mm"];
        vec![
            Table::new(
                "phantoms",
                &head(["variant", "phantom", "level_s_per_m"]),
                phantoms,
            ),
            Table::new("places", &head(place), places),
            Table::new("bound", &[&place[..], &["bound_mm"]].concat(), bounds),
        ]
    }
}

impl RankCriterion {
    /// Its name in the report.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Change => "mean |dV| over random places",
            Self::Relative => "mean |dV/V| over random places",
            Self::Bound => "the bound of a touch's place",
        }
    }
}

fn at(label: &str, [x, y]: &PointMm) -> [String; 3] {
    [label.to_owned(), x.to_string(), y.to_string()]
}

/// Cells of a row that ends with a change, as in [`CHANGE`].
fn cells(first: [String; 3], change: &Change) -> Vec<String> {
    let figures = [
        change.absolute,
        change.relative,
        change.over_proportional_noise,
        change.over_full_scale_noise,
    ];
    first
        .into_iter()
        .chain(figures.map(|value| value.to_string()))
        .collect()
}
