//! The report of the width study: the advice, and what the figures say about the paper's claims.

use super::{Change, LEVELS, RankCriterion, Width, WidthOutcome};
use crate::study::figure::short;
use crate::study::report::Report;
use crate::study::{CommandLine, StudyError};

impl Width {
    pub(super) fn build_report(&self, outcomes: &[WidthOutcome]) -> Result<Report, StudyError> {
        let mut advice: Vec<String> = self.advice(outcomes).into_iter().collect();
        advice.push(level_claim(outcomes));
        if self.settings.vary.is_none() {
            advice.push(width_claims(outcomes));
            advice.push(self.beyond_the_paper(outcomes));
        }
        Ok(Report {
            title: "Width study: which channels to build".to_owned(),
            command: self.command(),
            version: self.settings.version.clone(),
            seed: Some(self.settings.seed),
            advice,
            method: vec![method()],
            tables: vec![self.summary(outcomes)],
            csvs: self.csvs(outcomes),
            figures: self.figures(outcomes)?,
            files: Vec::new(),
        })
    }

    /// The shell command that repeats the study.
    #[must_use]
    pub fn command(&self) -> String {
        let settings = &self.settings;
        let mut line = CommandLine::new("study width", &settings.pad).option("seed", settings.seed);
        if let Some(vary) = &settings.vary {
            line = line.option("vary", vary);
        }
        let rank = match settings.rank {
            RankCriterion::Change => "change",
            RankCriterion::Relative => "relative",
            RankCriterion::Bound => "bound",
        };
        line.option("rank", rank)
            .flag("quick", settings.quick)
            .finish()
    }

    /// Which variant to build.
    fn advice(&self, outcomes: &[WidthOutcome]) -> Option<String> {
        let order = self.ranking(outcomes);
        let (first, last) = (*order.first()?, *order.last()?);
        let figure = |index: usize| {
            let one = &outcomes[index];
            match self.settings.rank {
                RankCriterion::Change => (1e3 * one.over_places(|c| c.absolute)[0], "mV/A"),
                RankCriterion::Relative => (100.0 * one.over_places(|c| c.relative)[0], "%"),
                RankCriterion::Bound => (one.bound_mm()[0], "mm"),
            }
        };
        let [label, other] = [first, last].map(|index| &self.variants[index].label);
        let [(best, unit), (worst, _)] = [first, last].map(figure);
        let what = match &self.settings.vary {
            Some(vary) => format!("the pad with {} = {label}", vary.path),
            None if label == "solid" => "the solid pad".to_owned(),
            None => format!("the lattice with channels of {label}"),
        };
        Some(format!(
            "Build {what}: it is the best by {} ({} {unit}; the worst is {other} with {} {unit}).",
            self.settings.rank.name(),
            short(best),
            short(worst)
        ))
    }

    fn beyond_the_paper(&self, outcomes: &[WidthOutcome]) -> String {
        let placed = outcomes
            .iter()
            .map(|one| one.over_places(|change| change.absolute)[0]);
        let bounds = outcomes.iter().map(|one| one.bound_mm()[0]);
        format!(
            "Beyond the paper: phantoms at crossings of lines favour narrow channels. Over {} random places the mean |dV| is {} mV/A \
             (figures places, places-change). The error of a touch's place at 60 dB cannot be smaller than {} mm (figure bound: \
             Cramer-Rao bound of a press of 7 mm radius with unknown size and strength, median over the pad). This bound, not \
             |dV|, is what a player notices.",
            self.places.len(),
            list(placed, 1e3),
            list(bounds, 1.0),
        )
    }
}

fn method() -> String {
    "Two-dimensional complete electrode model. The paper gives neither the number of lattice lines, nor the conductivity levels, \
     nor the size and places of its touches. Our choices: 11 x 11 lines (from the pad's text), levels of 2, 3, 4, 5 S/m over \
     1 S/m, discs of 5 mm radius at (50, 50), (30, 50) + (70, 50) and (30, 30) + (70, 30) + (50, 70) mm. |dV| is per ampere for \
     a layer one metre thick: divide by the layer's thickness in metres to get volts per ampere."
        .to_owned()
}

fn level_claim(outcomes: &[WidthOutcome]) -> String {
    let rises = outcomes.iter().all(|one| {
        (0..3).all(|phantom| {
            let relative = |level| one.phantom(phantom, level).relative;
            (1..LEVELS.len()).all(|level| relative(level) > relative(level - 1))
        })
    });
    format!(
        "Paper's claim \"the change grows with the touched conductivity\": {} (figures levels, levels-change).",
        if rises { "holds" } else { "does NOT hold" }
    )
}

fn width_claims(outcomes: &[WidthOutcome]) -> String {
    let top = |figure: fn(&Change) -> f64| {
        let figures = outcomes
            .iter()
            .map(|one| one.mean_of_phantoms(LEVELS.len() - 1, figure));
        figures.collect::<Vec<f64>>()
    };
    let hold = |values: &[f64]| match values.is_sorted_by(|a, b| a < b) {
        true => "hold",
        false => "do NOT hold",
    };
    let (absolute, relative) = (top(|change| change.absolute), top(|change| change.relative));
    format!(
        "Paper's claims \"the lattice gives more voltage variation than the solid\" and \"narrower channels give more\": for |dV| at \
         constant current they {} ({} mV/A from solid to 1 mm, figure change); for the relative change |dV/V| they {} ({} %, figure \
         relative).",
        hold(&absolute),
        list(absolute.iter().copied(), 1e3),
        hold(&relative),
        list(relative.iter().copied(), 100.0),
    )
}

fn list(values: impl Iterator<Item = f64>, unit: f64) -> String {
    values
        .map(|value| short(value * unit))
        .collect::<Vec<_>>()
        .join(", ")
}
