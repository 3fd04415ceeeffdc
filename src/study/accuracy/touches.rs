//! One, two and three touches on pads that the model does not know: what is found, and how far off, by SNR.

use serde::Serialize;

use super::Bench;
use super::draws::Draws;
use super::noise::{Instrument, NoiseKind, share};
use super::score::{Found, REACH_MM, Score};
use super::sensing::Rested;
use super::specimen::Specimen;
use super::stats::{Share, Spread};
use crate::study::{Merit, Press, PressBound, StudyError};

/// A force counts at most as this much off, as a share of the true one; so does its bound.
const MOST_FORCE_ERROR: f64 = 1.0;
/// Mean size of a Gaussian's error in units of its deviation: sqrt(2 / pi).
const MEAN_OF_DEVIATION: f64 = 0.797_884_560_802_865_4;

/// One state of a pad, read with every kind of noise.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    presses: Vec<Press>,
    /// In the order of [`Bench::noises`].
    seen: Vec<Seen>,
}

/// What one reading of it showed.
#[derive(Clone, Debug)]
struct Seen {
    score: Score,
    /// One for each touch; `None` if the voltages do not tell them.
    bounds: Option<Vec<PressBound>>,
    /// Of a single touch.
    merit: Option<Merit>,
}

/// Draws so many states with a number of touches on one specimen.
pub(super) fn solve(
    bench: &Bench,
    touches: usize,
    draws: usize,
    stream: u64,
) -> Result<Vec<Drawn>, StudyError> {
    let mut random = Draws::new(&bench.pad, bench.seed, stream);
    let specimen = Specimen::drawn(&bench.pad, &mut random)?;
    let seed = random.seed();
    let readers = bench
        .noises()
        .map(|(kind, snr_db)| {
            let instrument = Instrument {
                kind,
                snr_db,
                rest: &specimen.rest,
            };
            Ok((instrument, bench.sensing.rested(&instrument, seed)?))
        })
        .collect::<Result<Vec<_>, StudyError>>()?;
    (0..draws)
        .map(|_| {
            let presses = random.presses(touches)?;
            drawn(bench, &specimen, &readers, presses, random.seed())
        })
        .collect()
}

fn drawn(
    bench: &Bench,
    specimen: &Specimen,
    readers: &[(Instrument, Rested)],
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
    let seen = readers.iter().map(|(instrument, rested)| {
        let frame = instrument.frame(&volts, seed);
        let bounds = &bounds_at_0_db[instrument.kind as usize];
        let louder = |bound: &PressBound| bound.with_noise(share(instrument.snr_db));
        Seen {
            score: Score::of(&presses, &rested.contacts(&frame), REACH_MM * bench.scale),
            bounds: bounds
                .as_ref()
                .map(|bounds| bounds.iter().map(louder).collect()),
            merit: match presses.as_slice() {
                [press] => Some(rested.merit(&frame, press)),
                _ => None,
            },
        }
    });
    let seen = seen.collect();
    Ok(Drawn { presses, seen })
}

/// What draws of one number of touches gave with one noise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TouchFindings {
    /// Touches in each draw; 0 is the untouched pad.
    pub touches: usize,
    /// What the noise goes with.
    pub noise: NoiseKind,
    /// How strong it is, dB.
    pub snr_db: f64,
    /// Draws in which as many touches were seen as there were.
    pub counted_right: Share,
    /// Touches that were drawn.
    pub drawn: usize,
    /// Touches that were not found.
    pub missed: usize,
    /// Touches that were seen where there was none.
    pub false_touches: usize,
    /// Distances of found touches from the truth, mm.
    pub place_error_mm: Spread,
    /// The mean error of place that no unbiased method goes below, over all touches that were drawn, mm.
    pub place_bound_mm: Spread,
    /// Errors of force of found touches, as a share of the true force.
    pub force_error: Spread,
    /// The mean error of force that no unbiased method goes below, over all touches that were drawn.
    pub force_bound: Spread,
}

/// GREIT's figures of one touch with one noise: medians over the draws (where noise fills an image, its sums come near
/// zero, and a mean of ratios tells nothing).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImageFindings {
    /// What the noise goes with.
    pub noise: NoiseKind,
    /// How strong it is, dB.
    pub snr_db: f64,
    /// Draws.
    pub n: usize,
    /// The medians.
    #[serde(flatten)]
    pub median: Merit,
}

/// All draws of one number of touches, and what they gave with each noise.
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
            let seen: Vec<(&Drawn, &Seen)> = drawn
                .iter()
                .map(|draw| (*draw, &draw.seen[index]))
                .collect();
            let found: Vec<(&Press, Found)> = seen
                .iter()
                .flat_map(|(draw, seen)| draw.presses.iter().zip(&seen.score.found))
                .filter_map(|(press, found)| Some((press, (*found)?)))
                .collect();
            // Of every touch that was drawn, found or not: what could be found. An error of place ends at the reach
            // within which a touch counts as found, and so does its bound.
            let reach_mm = REACH_MM * bench.scale;
            let bounds: Vec<(f64, f64)> = seen
                .iter()
                .flat_map(|(draw, seen)| match &seen.bounds {
                    Some(bounds) => bounds
                        .iter()
                        .map(|bound| (bound.mean_mm(), MEAN_OF_DEVIATION * bound.volume_share))
                        .collect(),
                    None => vec![(f64::INFINITY, f64::INFINITY); draw.presses.len()],
                })
                .map(|(mm, share)| (mm.min(reach_mm), share.min(MOST_FORCE_ERROR)))
                .collect();
            TouchFindings {
                touches,
                noise,
                snr_db,
                counted_right: Share::counted(&seen, |(_, seen)| seen.score.is_counted_right()),
                drawn: touches * drawn.len(),
                missed: seen.iter().map(|(_, seen)| seen.score.missed()).sum(),
                false_touches: seen.iter().map(|(_, seen)| seen.score.false_touches).sum(),
                place_error_mm: Spread::of(found.iter().map(|(_, found)| found.off_mm)),
                place_bound_mm: Spread::of(bounds.iter().map(|(mm, _)| *mm)),
                force_error: Spread::of(
                    found
                        .iter()
                        .map(|(press, found)| force.error(press, found.force)),
                ),
                force_bound: Spread::of(bounds.iter().map(|(_, share)| *share)),
            }
        })
        .collect()
}

/// GREIT's figures of draws of one touch, with each noise.
pub(super) fn images(bench: &Bench, drawn: &[&Drawn]) -> Vec<ImageFindings> {
    bench
        .noises()
        .enumerate()
        .map(|(index, (noise, snr_db))| {
            let merits: Vec<Merit> = drawn
                .iter()
                .filter_map(|draw| draw.seen[index].merit)
                .collect();
            let median = |figure: fn(&Merit) -> f64| Spread::of(merits.iter().map(figure)).median;
            ImageFindings {
                noise,
                snr_db,
                n: merits.len(),
                median: Merit {
                    amplitude_response: median(|merit| merit.amplitude_response),
                    place_error_mm: median(|merit| merit.place_error_mm),
                    resolution: median(|merit| merit.resolution),
                    shape_deformation: median(|merit| merit.shape_deformation),
                    ringing: median(|merit| merit.ringing),
                },
            }
        })
        .collect()
}

/// What a force of 1 stands for. A force has no unit of its own: one scale for the whole pad is taken from its single
/// touches at the best SNR, and errors are what is left.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ForceScale {
    /// Volume of a press (rise x mm2) that reads as full force, by the median of single touches; `null` if none was
    /// found.
    pub full_force_mm2: f64,
}

impl ForceScale {
    /// Of draws of one touch. Forces at full scale tell nothing of it.
    pub(super) fn of(drawn: &[&Drawn]) -> Self {
        let volumes = drawn.iter().filter_map(|draw| {
            // The first noise is the best.
            let found = draw.seen[0].score.found[0]?;
            let tells = found.force > 0.0 && found.force < 1.0;
            tells.then(|| draw.presses[0].volume_mm2() / found.force)
        });
        Self {
            full_force_mm2: Spread::of(volumes).median,
        }
    }

    /// How far a force is off, as a share of the true one, both cut at full force.
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
