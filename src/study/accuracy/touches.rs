//! Detection, errors of place and errors of force of zero to three touches, by SNR.

use serde::Serialize;

use super::draws::Draws;
use super::noise::{Instrument, NoiseKind, share};
use super::score::{Found, REACH_MM, Score};
use super::sensing::RestedDetector;
use super::specimen::Specimen;
use super::spread::{Share, Spread};
use super::{Bench, MOST_TOUCHES};
use crate::study::{Merit, Press, PressBound, StudyError};

/// Largest error of force that is counted, as a share of the true force; the same for its bound.
const MOST_FORCE_ERROR: f64 = 1.0;
/// Mean absolute value of a Gaussian in units of its standard deviation: sqrt(2 / pi).
const MEAN_OF_DEVIATION: f64 = 0.797_884_560_802_865_4;

/// One state of a pad, read with every kind of noise.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    pub(super) presses: Vec<Press>,
    /// In the order of [`Bench::noises`].
    readings: Vec<Reading>,
}

/// The result of one reading.
#[derive(Clone, Debug)]
struct Reading {
    score: Score,
    /// One for each touch; `None` if the voltages do not determine them.
    bounds: Option<Vec<PressBound>>,
    /// Only for a single touch.
    merit: Option<Merit>,
}

/// Draws states with each number of touches on one specimen.
pub(super) fn solve(bench: &Bench, draws: usize, stream: u64) -> Result<Vec<Drawn>, StudyError> {
    let mut random = Draws::new(&bench.pad, bench.seed, stream);
    let specimen = Specimen::random(&bench.pad, &mut random)?;
    let seed = random.seed();
    let readers = bench
        .noises()
        .map(|(kind, snr_db)| {
            let instrument = Instrument {
                kind,
                snr_db,
                rest: &specimen.rest,
            };
            Ok((instrument, bench.rested(&instrument, seed)?))
        })
        .collect::<Result<Vec<_>, StudyError>>()?;
    (0..=MOST_TOUCHES)
        .flat_map(|touches| std::iter::repeat_n(touches, draws))
        .map(|touches| {
            let presses = random.presses(touches)?;
            read_state(bench, &specimen, &readers, presses, random.seed())
        })
        .collect()
}

/// Reads one state with every noise.
fn read_state(
    bench: &Bench,
    specimen: &Specimen,
    readers: &[(Instrument, RestedDetector)],
    presses: Vec<Press>,
    seed: u64,
) -> Result<Drawn, StudyError> {
    let pad = &bench.pad;
    let (volts, slopes) = match presses.as_slice() {
        [] => (specimen.rest.clone(), None),
        presses => {
            let (volts, slopes) = specimen.pressed(pad, presses)?;
            (volts, Some(slopes))
        }
    };
    let bounds_at_0_db = NoiseKind::ALL.map(|kind| {
        let deviations = kind.deviations(&volts, &specimen.rest);
        slopes
            .as_ref()
            .and_then(|slopes| slopes.bounds(&deviations))
    });
    let readings = readers.iter().map(|(instrument, rested)| {
        let frame = instrument.frame(&volts, seed);
        let bounds = &bounds_at_0_db[instrument.kind as usize];
        let scaled = |bound: &PressBound| bound.with_noise(share(instrument.snr_db));
        Reading {
            score: Score::new(&presses, &rested.contacts(&frame), REACH_MM * bench.scale),
            bounds: bounds
                .as_ref()
                .map(|bounds| bounds.iter().map(scaled).collect()),
            merit: match presses.as_slice() {
                [press] => Some(rested.merit(&frame, press)),
                _ => None,
            },
        }
    });
    let readings = readings.collect();
    Ok(Drawn { presses, readings })
}

/// Results of one number of touches with one noise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TouchFindings {
    /// Touches in each draw; 0 is the untouched pad.
    pub touches: usize,
    /// Kind of noise.
    pub noise: NoiseKind,
    /// SNR, dB.
    pub snr_db: f64,
    /// Draws in which as many touches were detected as there were.
    pub counted_right: Share,
    /// Number of touches drawn.
    pub drawn: usize,
    /// Touches not detected.
    pub missed: usize,
    /// Touches detected where there was none.
    pub false_touches: usize,
    /// Distances of detected touches from the truth, mm.
    pub place_error_mm: Spread,
    /// Bound of the mean error of place, over all touches drawn, mm.
    pub place_bound_mm: Spread,
    /// Errors of force of detected touches, as a share of the true force.
    pub force_error: Spread,
    /// Bound of the mean error of force, over all touches drawn.
    pub force_bound: Spread,
}

/// GREIT's figures of one touch with one noise: medians over the draws. (Where noise fills an image its sums come near zero, so
/// a mean of ratios is meaningless.)
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImageFindings {
    /// Kind of noise.
    pub noise: NoiseKind,
    /// SNR, dB.
    pub snr_db: f64,
    /// Draws.
    pub n: usize,
    /// The medians.
    #[serde(flatten)]
    pub median: Merit,
}

/// Results of all draws of one number of touches, with each noise.
pub(super) fn findings(
    bench: &Bench,
    touches: usize,
    drawn: &[&Drawn],
    force: ForceScale,
) -> Vec<TouchFindings> {
    bench
        .noises()
        .enumerate()
        .map(|(index, (noise, snr_db))| {
            let read: Vec<(&Drawn, &Reading)> = drawn
                .iter()
                .map(|draw| (*draw, &draw.readings[index]))
                .collect();
            let found: Vec<(&Press, Found)> = read
                .iter()
                .flat_map(|(draw, reading)| draw.presses.iter().zip(&reading.score.found))
                .filter_map(|(press, found)| Some((press, (*found)?)))
                .collect();
            let bounds = capped_bounds(&read, REACH_MM * bench.scale);
            let off_mm = found.iter().map(|(_, found)| found.off_mm);
            let force_errors = found
                .iter()
                .map(|(press, found)| force.error(press, found.force));
            TouchFindings {
                touches,
                noise,
                snr_db,
                counted_right: Share::counted(&read, |(_, one)| one.score.is_counted_right()),
                drawn: touches * drawn.len(),
                missed: read.iter().map(|(_, one)| one.score.missed()).sum(),
                false_touches: read.iter().map(|(_, one)| one.score.false_touches).sum(),
                place_error_mm: Spread::new(off_mm),
                place_bound_mm: Spread::new(bounds.iter().map(|(mm, _)| *mm)),
                force_error: Spread::new(force_errors),
                force_bound: Spread::new(bounds.iter().map(|(_, share)| *share)),
            }
        })
        .collect()
}

/// Bounds of place (mm) and force of every touch, detected or not. An error of place ends at the reach within which a touch
/// counts as detected, and so does its bound.
fn capped_bounds(read: &[(&Drawn, &Reading)], reach_mm: f64) -> Vec<(f64, f64)> {
    let capped = |mm: f64, share: f64| (mm.min(reach_mm), share.min(MOST_FORCE_ERROR));
    read.iter()
        .flat_map(|(draw, reading)| match &reading.bounds {
            Some(bounds) => bounds
                .iter()
                .map(|bound| capped(bound.mean_mm(), MEAN_OF_DEVIATION * bound.volume_share))
                .collect(),
            None => vec![capped(f64::INFINITY, f64::INFINITY); draw.presses.len()],
        })
        .collect()
}

/// GREIT's figures of all draws of one touch, with each noise.
pub(super) fn images(bench: &Bench, drawn: &[&Drawn]) -> Vec<ImageFindings> {
    bench
        .noises()
        .enumerate()
        .map(|(index, (noise, snr_db))| {
            let merits: Vec<Merit> = drawn
                .iter()
                .filter_map(|draw| draw.readings[index].merit)
                .collect();
            ImageFindings {
                noise,
                snr_db,
                n: merits.len(),
                median: Merit::summarised(|figure| Spread::new(merits.iter().map(figure)).median),
            }
        })
        .collect()
}

/// Meaning of a force of 1. A force has no unit: one scale for the whole pad is taken from its single touches at the highest
/// SNR, and errors are the remaining differences.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ForceScale {
    /// Volume of a press (rise x mm2) that is detected as full force, by the median of single touches; `null` without any.
    pub full_force_mm2: f64,
}

impl ForceScale {
    /// The scale from draws of one touch. Forces at the ends of the scale are ignored.
    pub(super) fn from_draws(drawn: &[&Drawn]) -> Self {
        let volumes = drawn.iter().filter_map(|draw| {
            // The first noise has the highest SNR.
            let found = draw.readings[0].score.found[0]?;
            let is_inside = found.force > 0.0 && found.force < 1.0;
            is_inside.then(|| draw.presses[0].volume_mm2() / found.force)
        });
        Self {
            full_force_mm2: Spread::new(volumes).median,
        }
    }

    /// Error of a force as a share of the true one, both cut at full force.
    fn error(self, press: &Press, force: f64) -> f64 {
        let truth = (press.volume_mm2() / self.full_force_mm2).min(1.0);
        ((force - truth).abs() / truth).min(MOST_FORCE_ERROR)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_are_compared_as_shares_and_cut_at_full_force() {
        let scale = ForceScale {
            full_force_mm2: 100.0,
        };
        let press = |volume_mm2: f64| Press {
            centre_mm: [0.0, 0.0],
            radius_mm: (2.0 * volume_mm2 / std::f64::consts::PI).sqrt(),
            rise: 1.0,
        };
        assert!((scale.error(&press(50.0), 0.4) - 0.2).abs() < 1e-12);
        assert_eq!(
            scale.error(&press(250.0), 1.0),
            0.0,
            "full force is full force"
        );
        assert_eq!(scale.error(&press(10.0), 0.9), 1.0, "at most all of it");
    }
}
