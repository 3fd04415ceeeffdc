//! The figures of the width study.

use super::{Change, LEVELS, TOUCH_MM, Width, WidthOutcome};
use crate::study::figure::{Chart, Figure, Series};
use crate::study::{Phantom, StudyError};

const PERCENT: &str = "mean |dV/V|, %";
const MILLIVOLTS: &str = "mean |dV|, mV/A (2-D)";

fn percent(change: &Change) -> f64 {
    100.0 * change.relative
}

fn milli(change: &Change) -> f64 {
    1e3 * change.absolute
}

impl Width {
    pub(super) fn figures(&self, outcomes: &[WidthOutcome]) -> Result<Vec<Figure>, StudyError> {
        let phantoms = self.phantom_charts(outcomes).into_iter();
        let charts = phantoms.chain(self.place_charts(outcomes));
        charts.map(|chart| chart.draw()).collect()
    }

    fn phantom_charts(&self, outcomes: &[WidthOutcome]) -> [Chart; 4] {
        let levels = "by level, mean of the phantoms";
        [
            self.chart(
                ("change", "Change at constant current, 5 S/m", MILLIVOLTS),
                by_phantom(outcomes, milli),
            ),
            self.chart(
                ("relative", "Relative change, 5 S/m", PERCENT),
                by_phantom(outcomes, percent),
            ),
            self.chart(
                ("levels", &format!("Relative change {levels}"), PERCENT),
                by_level(outcomes, percent),
            ),
            self.chart(
                ("levels-change", &format!("Change {levels}"), MILLIVOLTS),
                by_level(outcomes, milli),
            ),
        ]
    }

    fn place_charts(&self, outcomes: &[WidthOutcome]) -> [Chart; 4] {
        let at_places = |figure: fn(&Change) -> f64| {
            let name = format!("{} places", self.places.len());
            line(&name, outcomes, |one| one.over_places(figure))
        };
        let over_noise = |name: &str, figure: fn(&Change) -> f64| Series {
            name: name.to_owned(),
            ..at_places(figure)
        };
        let noise = vec![
            over_noise("of each reading", |change| change.over_proportional_noise),
            over_noise("of full scale", |change| change.over_full_scale_noise),
        ];
        let bounds = format!("{} places", self.bound_places.len());
        let bounds = vec![line(&bounds, outcomes, WidthOutcome::bound_mm)];
        let places = "at random places: mean, least, greatest";
        let bound = "Cramer-Rao bound of a touch's place (60 dB): median, range";
        [
            self.chart(
                ("places", &format!("Relative change {places}"), PERCENT),
                vec![at_places(percent)],
            ),
            self.chart(
                ("places-change", &format!("Change {places}"), MILLIVOLTS),
                vec![at_places(milli)],
            ),
            self.chart(
                (
                    "noise",
                    "Change over noise (60 dB), random places",
                    "RMS of dV / noise",
                ),
                noise,
            ),
            self.chart(("bound", bound, "mm"), bounds),
        ]
    }

    /// Label of the x axis: the parameter that differs between variants.
    pub(super) fn parameter(&self) -> &str {
        let vary = self.settings.vary.as_ref();
        vary.map_or("width of the channels", |vary| &vary.path)
    }

    fn chart(&self, (name, title, y_label): (&str, &str, &str), series: Vec<Series>) -> Chart {
        Chart {
            name: name.to_owned(),
            title: title.to_owned(),
            x_label: self.parameter().to_owned(),
            y_label: y_label.to_owned(),
            places: self
                .variants
                .iter()
                .map(|variant| variant.label.clone())
                .collect(),
            series,
            ..Chart::default()
        }
    }
}

fn line(
    name: &str,
    outcomes: &[WidthOutcome],
    point: impl Fn(&WidthOutcome) -> [f64; 3],
) -> Series {
    Series {
        name: name.to_owned(),
        points: outcomes.iter().map(point).collect(),
        ..Series::default()
    }
}

/// A line for each phantom at the highest level.
fn by_phantom(outcomes: &[WidthOutcome], figure: fn(&Change) -> f64) -> Vec<Series> {
    let phantoms = Phantom::points(TOUCH_MM).into_iter().enumerate();
    phantoms
        .map(|(index, phantom)| {
            line(phantom.name, outcomes, |one| {
                [figure(&one.phantom(index, LEVELS.len() - 1)); 3]
            })
        })
        .collect()
}

/// A line for each level.
fn by_level(outcomes: &[WidthOutcome], figure: fn(&Change) -> f64) -> Vec<Series> {
    let levels = LEVELS.iter().enumerate();
    levels
        .map(|(level, s_per_m)| {
            line(&format!("{s_per_m} S/m"), outcomes, |one| {
                [one.mean_of_phantoms(level, figure); 3]
            })
        })
        .collect()
}
