//! Learns the maps of a pad that no model describes, from single presses at known places.
//!
//! The relative changes of all presses span a few directions. Each direction's coordinate has a Gaussian process over the place, with
//! its own length and noise, chosen by leave-one-out; noise that does not depend on the place becomes a flat map. What presses that
//! were left out leave unexplained is kept as well: play must not take it for another touch.

use std::sync::Arc;

use faer::{Mat, Side};

use super::component_maps::{choose, distinct};
use super::error::{CalibrateError, FEWEST_TO_LEARN, PlaceErrors};
use super::maps::{self, rows, subset};
use super::presses::{Presses, shuffled};
use super::process::{self, Process};
use crate::eit::ResponseBuilder;
use crate::pad::{LearnedMaps, Pad};
use crate::touch::{Locator, SensingBuilder};
use crate::types::{Method, PointMm, distance_mm};

/// Steps of the maps along the pad's longer side.
const STEPS_ALONG: f64 = 24.0;
/// Most directions that have a map.
const MOST_DIRECTIONS: usize = 48;
/// Directions with less than this share of the strongest one's energy are left out.
const LEAST_ENERGY: f64 = 1e-6;
/// Most directions that channels share in what is left unexplained, and presses for each of them.
const MOST_SHARED: usize = 24;
const PRESSES_PER_SHARED: usize = 6;
/// Least share of a channel's unexplained variance that is its own.
const LEAST_OWN_SHARE: f64 = 0.05;
/// Least deviation of a channel, as a share of the largest.
const LEAST_DEVIATION: f64 = 1e-4;
/// Most presses for the choice of lengths and noises, and for what is left unexplained.
const MOST_FOR_CHOICE: usize = 400;
const MOST_FOR_RESIDUALS: usize = 1000;
/// Every press with this number is left out to estimate the error.
const LEFT_OUT: usize = 5;
/// Relative deviation of a reading that is as good as none.
const NEGLIGIBLE: f64 = 1e-7;
/// A contact farther than this from the press is another touch, mm.
const FOUND_WITHIN_MM: f64 = 20.0;

/// How presses that were left out are located on the learned pad, as play does it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearnedErrors {
    /// Presses that were left out.
    pub presses: usize,
    /// How many of them gave exactly one touch, near the place.
    pub found: usize,
    /// Errors of those found.
    pub places: PlaceErrors,
}

/// Learns the maps of a pad of the given width and height, mm.
///
/// # Errors
/// Presses without the untouched readings; presses too similar to learn from.
pub fn learn_maps(presses: &Presses, size_mm: [f64; 2]) -> Result<LearnedMaps, CalibrateError> {
    let all: Vec<usize> = (0..presses.len()).collect();
    let changes = presses
        .relative_changes(&all)
        .ok_or(CalibrateError::NotRelative)?;
    let places = presses.places(&all);
    let scales = channel_scales(&changes, &places)?;
    let scaled = Mat::from_fn(changes.nrows(), changes.ncols(), |r, c| {
        changes[(r, c)] / scales[c]
    });
    let directions = directions(&scaled)?;
    let coordinates = &scaled * &directions;

    let some = subset(presses.len(), MOST_FOR_CHOICE);
    let chosen = choose(&rows(&coordinates, &some), &rows(&places, &some))?;
    let counts = size_mm.map(|side| {
        let pitch_mm = size_mm[0].max(size_mm[1]) / STEPS_ALONG;
        libm::ceil(side / pitch_mm - 1e-9) as usize + 1
    });
    let grid = grid(counts, size_mm);
    let some = subset(presses.len(), MOST_FOR_RESIDUALS);
    let near_coordinates = rows(&coordinates, &some);
    let near_places = rows(&places, &some);
    let distances2 = process::squared_distances(&near_places, &near_places);
    let mut responses = Mat::zeros(grid.nrows(), coordinates.ncols());
    let mut left_out = Mat::zeros(some.len(), coordinates.ncols());
    for hyper in distinct(&chosen) {
        let which: Vec<usize> = (0..chosen.len()).filter(|k| chosen[*k] == hyper).collect();
        let process = Process::fit(places.clone(), &columns(&coordinates, &which), hyper)?;
        put_columns(&mut responses, &which, &process.predict(&grid));
        let near = columns(&near_coordinates, &which);
        let residuals = process::leave_one_out(&distances2, &near, hyper)?.residuals;
        put_columns(&mut left_out, &which, &residuals);
    }
    // What is left of a press: what its directions miss, and what lies outside of them.
    let explained = (&near_coordinates - &left_out) * directions.transpose();
    let unexplained = rows(&scaled, &some) - explained;
    let (deviations, shared) = unexplained_parts(&unexplained, &scales)?;
    let unscaled = Mat::from_fn(directions.ncols(), scales.len(), |k, c| {
        directions[(c, k)] * scales[c]
    });
    Ok(LearnedMaps {
        presses: presses.len(),
        counts,
        directions: to_lists(&unscaled),
        responses: to_lists(&responses),
        deviations,
        shared,
    })
}

/// Some columns of a matrix.
fn columns(matrix: &Mat<f64>, which: &[usize]) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), which.len(), |r, c| matrix[(r, which[c])])
}

/// Replaces some columns of a matrix.
fn put_columns(matrix: &mut Mat<f64>, which: &[usize], by: &Mat<f64>) {
    for (from, to) in which.iter().enumerate() {
        matrix.col_mut(*to).copy_from(by.col(from));
    }
}

/// The rows of a matrix as lists.
fn to_lists(matrix: &Mat<f64>) -> Vec<Vec<f64>> {
    let rows = 0..matrix.nrows();
    rows.map(|row| matrix.row(row).iter().copied().collect())
        .collect()
}

/// Learns from four fifths of the presses and locates the others.
///
/// # Errors
/// See [`learn_maps`]; too few presses to leave some out.
pub fn learned_errors(presses: &Presses, pad: &Pad) -> Result<LearnedErrors, CalibrateError> {
    if presses.len() < FEWEST_TO_LEARN {
        return Err(CalibrateError::TooFewToLearn {
            found: presses.len(),
        });
    }
    let order = shuffled(presses.len());
    let ranked = |is_test: bool| {
        let ranks = (0..order.len()).filter(move |rank| (rank % LEFT_OUT == 0) == is_test);
        ranks.map(|rank| order[rank]).collect::<Vec<_>>()
    };
    let (test, train) = (ranked(true), ranked(false));
    let train = presses.some(&train).map_err(|_| CalibrateError::Alike)?;
    let pad = Pad {
        learned: Some(Arc::new(learn_maps(&train, pad.outline.size_mm())?)),
        ..pad.clone()
    };
    let changes = presses
        .relative_changes(&test)
        .ok_or(CalibrateError::NotRelative)?;
    let mut locator = locator(&pad).ok_or(CalibrateError::Alike)?;
    let (mut predicted, mut truth) = (Vec::new(), Vec::new());
    for (row, press) in test.iter().enumerate() {
        let frame: Vec<f32> = (0..presses.channels())
            .map(|c| changes[(row, c)] as f32)
            .collect();
        locator.forget_touches();
        locator.take_frame(&frame, 1.0);
        locator.locate(row as u64 * 10_000_000, 1.0, 0.0);
        let place_mm = presses.list()[*press].place_mm;
        let contacts: Vec<PointMm> = locator
            .contacts()
            .map(|contact| contact.centre_mm)
            .collect();
        if let [contact] = contacts[..]
            && distance_mm(contact, place_mm) <= FOUND_WITHIN_MM
        {
            predicted.push(contact);
            truth.push(place_mm);
        }
    }
    if predicted.is_empty() {
        return Err(CalibrateError::Disagree);
    }
    Ok(LearnedErrors {
        presses: test.len(),
        found: predicted.len(),
        places: PlaceErrors::between(&predicted, &truth),
    })
}

/// Locates touches on a pad as play does; none if its table cannot be built.
fn locator(pad: &Pad) -> Option<Locator> {
    let builder = ResponseBuilder::new(pad).ok()?;
    let solved: Vec<_> = (0..builder.rows())
        .map(|row| builder.solve_row(row))
        .collect();
    let table = Arc::new(builder.finish(&solved));
    // The noise of presses is in them already.
    let noise = vec![NEGLIGIBLE; pad.channels()].into();
    let sensing = SensingBuilder::new(pad, Method::default())
        .ok()?
        .with_table(table);
    Some(Locator::new(sensing.build(&noise).ok()?.locator_model?))
}

/// What each channel's own map leaves of a press: the unit in which channels are compared.
fn channel_scales(changes: &Mat<f64>, places: &Mat<f64>) -> Result<Vec<f64>, CalibrateError> {
    let hyper = maps::choose(changes, places)?;
    let some = subset(places.nrows(), MOST_FOR_CHOICE);
    let (near, shown) = (rows(places, &some), rows(changes, &some));
    let distances2 = process::squared_distances(&near, &near);
    let residuals = process::leave_one_out(&distances2, &shown, hyper)?.residuals;
    let count = residuals.nrows() as f64;
    let scales: Vec<f64> = (0..residuals.ncols())
        .map(|c| libm::sqrt(residuals.col(c).iter().map(|r| r * r).sum::<f64>() / count))
        .collect();
    let largest = scales.iter().copied().fold(0.0, f64::max);
    if largest <= 0.0 {
        return Err(CalibrateError::Alike);
    }
    Ok(scales
        .iter()
        .map(|scale| scale.max(LEAST_DEVIATION * largest))
        .collect())
}

/// The directions that hold most of the changes: channels by directions, orthonormal.
fn directions(scaled: &Mat<f64>) -> Result<Mat<f64>, CalibrateError> {
    let energy = scaled.transpose() * scaled;
    let eigen = energy
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| CalibrateError::Alike)?;
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    let channels = scaled.ncols();
    let least = LEAST_ENERGY * values[channels - 1];
    let kept: Vec<usize> = (0..channels)
        .rev()
        .take(MOST_DIRECTIONS.min(scaled.nrows() - 1))
        .filter(|k| values[*k] > least)
        .collect();
    Ok(Mat::from_fn(channels, kept.len(), |row, k| {
        vectors[(row, kept[k])]
    }))
}

/// The places of a grid over a pad's box, row by row: places by 2, mm.
fn grid(counts: [usize; 2], size_mm: [f64; 2]) -> Mat<f64> {
    Mat::from_fn(counts[0] * counts[1], 2, |place, axis| {
        let step = [place % counts[0], place / counts[0]][axis];
        size_mm[axis] * step as f64 / (counts[axis] - 1) as f64
    })
}

/// Splits what is left unexplained (presses by channels, in units of `scales`) into each channel's own deviation and shared directions,
/// both as relative changes.
fn unexplained_parts(
    unexplained: &Mat<f64>,
    scales: &[f64],
) -> Result<(Vec<f64>, Vec<Vec<f64>>), CalibrateError> {
    let count = unexplained.nrows();
    let covariance = unexplained.transpose() * unexplained * faer::Scale(1.0 / count as f64);
    let eigen = covariance
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| CalibrateError::Alike)?;
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    let channels = scales.len();
    let kept = MOST_SHARED.min(count / PRESSES_PER_SHARED).min(channels);
    let strongest: Vec<usize> = (0..channels).rev().take(kept).collect();
    let shared_variance = |c: usize| {
        strongest
            .iter()
            .map(|k| values[*k] * vectors[(c, *k)] * vectors[(c, *k)])
            .sum::<f64>()
    };
    let deviations = (0..channels)
        .map(|c| {
            let whole = covariance[(c, c)].max(LEAST_OWN_SHARE);
            scales[c] * libm::sqrt((whole - shared_variance(c)).max(LEAST_OWN_SHARE * whole))
        })
        .collect();
    let shared = strongest
        .iter()
        .map(|k| {
            let length = libm::sqrt(values[*k].max(0.0));
            (0..channels)
                .map(|c| length * vectors[(c, *k)] * scales[c])
                .collect()
        })
        .collect();
    Ok((deviations, shared))
}
