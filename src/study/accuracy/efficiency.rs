//! How near the sensing comes to the Cramer-Rao bound where nothing but noise stands between: the pad is exactly as the
//! model takes it, on the model's own mesh.
//!
//! The bound takes the untouched pad as known; the sensing has to learn it from two seconds of frames.

use serde::Serialize;

use super::Bench;
use super::draws::Draws;
use super::noise::{Instrument, NoiseKind, share};
use super::score::{REACH_MM, Score};
use super::stats::Spread;
use crate::study::{Press, StudyError};
use crate::types::PointMm;

/// Noise in proportion to each reading, dB.
pub(super) const SNR_DB: f64 = 60.0;
/// Radius (mm) and rise of the press: a fingertip's.
pub(super) const PRESS: (f64, f64) = (7.0, 1.2);

/// What one place gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlaceFindings {
    /// Where, mm.
    pub place_mm: PointMm,
    /// Draws.
    pub draws: usize,
    /// Draws in which the touch was not found; they are in no error.
    pub missed: usize,
    /// Touches that were seen where there was none.
    pub false_touches: usize,
    /// Root mean square error of place, mm.
    pub rmse_mm: f64,
    /// Its Cramer-Rao bound, size and strength unknown, mm; `null` if the voltages do not tell the touch.
    pub bound_mm: f64,
    /// The one over the other.
    pub ratio: f64,
}

/// Reads one press at a place so many times.
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
    let rested = bench.sensing.rested(&instrument, random.seed())?;
    let scores: Vec<Score> = (0..draws)
        .map(|_| {
            let contacts = rested.contacts(&instrument.frame(&volts, random.seed()));
            Score::of(&presses, &contacts, REACH_MM * bench.scale)
        })
        .collect();
    let found = scores.iter().filter_map(|score| score.found[0]);
    let rmse_mm = Spread::of(found.map(|found| found.off_mm)).rms;
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

/// The ratios over all places at which the touch was found and is told.
pub(super) fn ratios(places: &[PlaceFindings]) -> Spread {
    Spread::of(
        places
            .iter()
            .map(|place| place.ratio)
            .filter(|ratio| ratio.is_finite()),
    )
}
