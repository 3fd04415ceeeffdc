//! Maps learned from presses, as written by `gelpad calibrate`.

use serde::Deserialize;
use toml::Spanned;

use crate::pad::{LearnedMaps, Pad};
use crate::types::Diagnostic;

/// Most places of a grid, and directions.
const MOST_PLACES: usize = 10_000;
const MOST_DIRECTIONS: usize = 512;
/// Largest relative change that a press can cause: a reading near zero changes by many times itself.
const MOST_CHANGE: f64 = 1e6;

/// The table `learned`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LearnedSpec {
    /// How many presses the maps come from.
    presses: usize,
    /// Places along x and y.
    counts: Spanned<[usize; 2]>,
    directions: Spanned<Vec<Vec<f64>>>,
    responses: Spanned<Vec<Vec<f64>>>,
    deviations: Spanned<Vec<f64>>,
    shared: Spanned<Vec<Vec<f64>>>,
}

/// The maps of a pad.
pub(super) fn checked(spec: &LearnedSpec, pad: &Pad) -> Result<LearnedMaps, Diagnostic> {
    let channels = pad.channels();
    let counts = *spec.counts.get_ref();
    let places = counts[0].saturating_mul(counts[1]);
    if counts.iter().any(|count| *count < 2) || places > MOST_PLACES {
        let message =
            format!("`counts` are 2 or more places along x and y, {MOST_PLACES} at most together");
        return Err(at_start(&spec.counts, message));
    }
    let directions = spec.directions.get_ref().len();
    if directions == 0 || directions > MOST_DIRECTIONS {
        let message = format!("`directions` are 1 to {MOST_DIRECTIONS} lists");
        return Err(at_start(&spec.directions, message));
    }
    let of_channels = format!("of {channels} relative changes, one for each channel");
    check_lists(&spec.directions, "directions", channels, &of_channels)?;
    check_lists(&spec.shared, "shared", channels, &of_channels)?;
    let of_directions = format!("of {directions} numbers, one for each direction");
    check_lists(&spec.responses, "responses", directions, &of_directions)?;
    if spec.responses.get_ref().len() != places {
        let message = format!("`responses` are {places} lists, one for each place of `counts`");
        return Err(at_start(&spec.responses, message));
    }
    let deviations = spec.deviations.get_ref();
    let is_deviation = |value: &f64| *value > 0.0 && *value <= MOST_CHANGE;
    if deviations.len() != channels || !deviations.iter().all(is_deviation) {
        let message = format!("`deviations` are {channels} numbers above 0, one for each channel");
        return Err(at_start(&spec.deviations, message));
    }
    Ok(LearnedMaps {
        presses: spec.presses,
        counts,
        directions: spec.directions.get_ref().clone(),
        responses: spec.responses.get_ref().clone(),
        deviations: deviations.clone(),
        shared: spec.shared.get_ref().clone(),
    })
}

/// Every list has the right length, and numbers that presses can give.
fn check_lists(
    lists: &Spanned<Vec<Vec<f64>>>,
    key: &str,
    length: usize,
    meaning: &str,
) -> Result<(), Diagnostic> {
    // NaN is within no bound.
    let is_sound = |list: &Vec<f64>| {
        list.len() == length && list.iter().all(|value| value.abs() <= MOST_CHANGE)
    };
    match (1..).zip(lists.get_ref()).find(|(_, list)| !is_sound(list)) {
        None => Ok(()),
        Some((number, _)) => {
            let message = format!("list {number} of `{key}` is not {meaning}");
            Err(at_start(lists, message))
        }
    }
}

/// A mistake in a value of thousands of numbers, of which only the start is shown.
fn at_start<T>(value: &Spanned<T>, message: String) -> Diagnostic {
    let start = value.span().start;
    Diagnostic::new(start..start + 1, message, "starts here")
}
