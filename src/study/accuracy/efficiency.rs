//! The sensing against the Cramer-Rao bound on a pad that equals its model, on the model's own mesh: noise is the only source
//! of error.
//!
//! The bound takes the untouched pad as known; the sensing learns it from two seconds of frames.

use serde::Serialize;

use super::Bench;
use super::draws::Draws;
use super::noise::{Instrument, NoiseKind, share};
use super::score::{REACH_MM, Score};
use super::spread::Spread;
use crate::stats::rms;
use crate::study::{Press, StudyError};
use crate::types::PointMm;

/// SNR with noise proportional to each reading, dB.
pub(super) const SNR_DB: f64 = 60.0;
/// Radius (mm) and rise of the press: a fingertip.
pub(super) const PRESS: (f64, f64) = (7.0, 1.2);

/// Results at one place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlaceFindings {
    /// The place, mm.
    pub place_mm: PointMm,
    /// Draws.
    pub draws: usize,
    /// Draws in which the touch was not detected; they do not enter the error.
    pub missed: usize,
    /// Touches detected where there was none.
    pub false_touches: usize,
    /// Root mean square error of place, mm.
    pub rmse_mm: f64,
    /// Its Cramer-Rao bound with size and strength unknown, mm; `null` if the voltages do not determine the touch.
    pub bound_mm: f64,
    /// Error over bound.
    pub ratio: f64,
}

/// Reads one press at a place `draws` times.
pub(super) fn solve(
    bench: &Bench,
    place_mm: PointMm,
    draws: usize,
    stream: u64,
) -> Result<PlaceFindings, StudyError> {
    let pad = &bench.pad;
    let specimen = &bench.ideal;
    let presses = [Press {
        centre_mm: place_mm,
        radius_mm: PRESS.0 * bench.scale,
        rise: PRESS.1,
    }];
    let (volts, slopes) = specimen.pressed(pad, &presses)?;
    let kind = NoiseKind::Proportional;
    let bound_mm = slopes
        .bounds(&kind.deviations(&volts, &specimen.rest))
        .map_or(f64::NAN, |bounds| {
            bounds[0].with_noise(share(SNR_DB)).rms_mm()
        });
    let mut random = Draws::new(pad, bench.seed, stream);
    let instrument = Instrument {
        kind,
        snr_db: SNR_DB,
        rest: &specimen.rest,
    };
    let rested = bench.sensing.rested(&instrument, random.seed());
    let scores: Vec<Score> = (0..draws)
        .map(|_| {
            let contacts = rested.contacts(&instrument.frame(&volts, random.seed()));
            Score::new(&presses, &contacts, REACH_MM * bench.scale)
        })
        .collect();
    let found = scores.iter().filter_map(|score| score.found[0]);
    let rmse_mm = rms(found.map(|found| found.off_mm));
    Ok(PlaceFindings {
        place_mm,
        draws,
        missed: scores.iter().map(Score::missed).sum(),
        false_touches: scores.iter().map(|score| score.false_touches).sum(),
        rmse_mm,
        bound_mm,
        ratio: rmse_mm / bound_mm,
    })
}

/// Spread of the ratios over all places that have one.
pub(super) fn ratios(places: &[PlaceFindings]) -> Spread {
    Spread::new(
        places
            .iter()
            .map(|place| place.ratio)
            .filter(|ratio| ratio.is_finite()),
    )
}
