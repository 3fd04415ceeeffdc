//! `gelpad calibrate --presses TRAIN --evaluate TEST`: locates touches from their voltages alone and prints their errors.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;

use anyhow::bail;
use faer::Mat;
use serde::Serialize;

use super::error_text;
use crate::app::calibration::{load_presses, load_touch_rows};
use crate::calibrate::{PlaceErrors, Presses, Regression, SuperposedMaps, TouchRow};
use crate::cli::exit::Ending;
use crate::cli::message::say;
use crate::cli::progress::Spinner;
use crate::types::{PointMm, distance_mm};

/// The printed line.
#[derive(Serialize)]
struct Evaluation {
    n_train: usize,
    n_test: usize,
    #[serde(flatten)]
    all: Errors,
    /// By the number of touches in a row.
    by_count: BTreeMap<usize, CountEvaluation>,
}

/// Errors of places, mm.
#[derive(Serialize)]
struct Errors {
    mean_mm: f64,
    median_mm: f64,
    p95_mm: f64,
}

/// Rows with the same number of touches.
#[derive(Serialize)]
struct CountEvaluation {
    n_test: usize,
    #[serde(flatten)]
    errors: Errors,
    #[serde(flatten)]
    region: Option<RegionEvaluation>,
}

/// How far the stated region of 90 % can be trusted.
#[derive(Serialize)]
struct RegionEvaluation {
    /// Mean radius, mm.
    region_mm: f64,
    /// Share of the test presses within their region.
    region_share: f64,
}

pub(super) fn evaluate(train: &Path, test: &Path) -> anyhow::Result<Ending> {
    let (presses, unseen) = (load_presses(train)?, load_touch_rows(test)?);
    if presses.channels() != unseen.channels() {
        bail!(
            "{}: {} channels, but {} has {}: both must come from the same pad",
            test.display(),
            unseen.channels(),
            train.display(),
            presses.channels()
        );
    }
    let spinner = Spinner::new();
    let mut by_count: BTreeMap<usize, Vec<&TouchRow>> = BTreeMap::new();
    for row in unseen.list() {
        by_count.entry(row.places_mm.len()).or_default().push(row);
    }
    let (mut located, mut truth) = (Vec::new(), Vec::new());
    let mut evaluations = BTreeMap::new();
    for (count, rows) in by_count {
        let changes = Mat::from_fn(rows.len(), presses.channels(), |row, channel| {
            rows[row].changes[channel]
        });
        let wanted: Vec<PointMm> = rows.iter().flat_map(|row| row.places_mm.clone()).collect();
        let (found, region) = match count {
            1 => locate_single(&presses, &changes, &wanted, &spinner)?,
            _ => {
                spinner.show(&format!("{count} touches at the same time"));
                let found = SuperposedMaps::fit(&presses, count)?.locate(&changes);
                let pairs = found.into_iter().zip(&rows);
                let matched = pairs.flat_map(|(found, row)| matched(found, &row.places_mm));
                (matched.collect(), None)
            }
        };
        let evaluation = CountEvaluation {
            n_test: rows.len(),
            errors: Errors::new(PlaceErrors::between(&found, &wanted)),
            region,
        };
        evaluations.insert(count, evaluation);
        located.extend(found);
        truth.extend(wanted);
    }
    drop(spinner);
    let line = serde_json::to_string(&Evaluation {
        n_train: presses.len(),
        n_test: unseen.list().len(),
        all: Errors::new(PlaceErrors::between(&located, &truth)),
        by_count: evaluations,
    })?;
    writeln!(std::io::stdout(), "{line}")?;
    Ok(Ending::Done)
}

/// Places of single presses, and how many are within their region.
fn locate_single(
    presses: &Presses,
    changes: &Mat<f64>,
    wanted: &[PointMm],
    spinner: &Spinner,
) -> anyhow::Result<(Vec<PointMm>, Option<RegionEvaluation>)> {
    let regression = Regression::fit(presses, &mut |stage| spinner.show(stage))?;
    let (found, radii_mm) = regression.predict_with_region(changes);
    let within = found
        .iter()
        .zip(wanted)
        .zip(&radii_mm)
        .filter(|((a, b), radius_mm)| distance_mm(**a, **b) <= **radius_mm)
        .count();
    say(&format!(
        "cross-validation predicted {}",
        error_text(regression.expected())
    ));
    let count = found.len() as f64;
    let region = RegionEvaluation {
        region_mm: radii_mm.iter().sum::<f64>() / count,
        region_share: within as f64 / count,
    };
    Ok((found, Some(region)))
}

/// Places in the order of the true ones that makes the sum of their distances least.
fn matched(found: Vec<PointMm>, truth: &[PointMm]) -> Vec<PointMm> {
    let cost = |order: &[usize]| -> f64 {
        let pairs = order.iter().zip(truth);
        pairs
            .map(|(index, place)| distance_mm(found[*index], *place))
            .sum()
    };
    let orders = orders(found.len());
    let best = orders
        .into_iter()
        .min_by(|a, b| cost(a).total_cmp(&cost(b)));
    best.unwrap_or_default()
        .into_iter()
        .map(|index| found[index])
        .collect()
}

/// All orders of 0 to n - 1.
fn orders(count: usize) -> Vec<Vec<usize>> {
    let Some(last) = count.checked_sub(1) else {
        return vec![Vec::new()];
    };
    orders(last)
        .into_iter()
        .flat_map(|order| {
            (0..=last).map(move |at| {
                let mut longer = order.clone();
                longer.insert(at, last);
                longer
            })
        })
        .collect()
}

impl Errors {
    fn new(errors: PlaceErrors) -> Self {
        Self {
            mean_mm: errors.mean_mm,
            median_mm: errors.median_mm,
            p95_mm: errors.p95_mm,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_compared_in_the_best_order() {
        let found = vec![[9.0, 0.0], [0.0, 1.0], [5.0, 5.0]];
        let truth = [[0.0, 0.0], [5.0, 6.0], [10.0, 0.0]];
        assert_eq!(matched(found, &truth), [[0.0, 1.0], [5.0, 5.0], [9.0, 0.0]]);
        assert_eq!(orders(3).len(), 6);
    }
}
