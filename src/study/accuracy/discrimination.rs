//! Two-point discrimination: the distance at which two touches are still detected as two, and whether one touch of another
//! shape is detected as one.

use serde::Serialize;

use super::Bench;
use super::draws::{Draws, SingleShape};
use super::noise::{Instrument, NoiseKind, share};
use super::score::{REACH_MM, Score};
use super::specimen::Specimen;
use super::spread::{Share, Spread};
use crate::pad::TouchSign;
use crate::study::StudyError;
use crate::types::Contact;

/// SNR with noise proportional to each reading, dB.
pub(super) const SNR_DB: f64 = 60.0;
/// Two touches are resolved if exactly two are detected, both within this distance of the truth, mm: well within a finger's
/// radius.
pub(super) const WITHIN_MM: f64 = 4.5;

/// Share of resolved pairs from which a distance counts as reliable.
pub(super) const RELIABLE: f64 = 0.95;

/// What was detected of one pair.
#[derive(Clone, Debug)]
pub(super) struct PairDrawn {
    detected: usize,
    resolved: bool,
    /// Bound of the mean error of place for each touch, mm.
    bounds_mm: Vec<f64>,
}

/// Draws pairs of presses on one specimen.
pub(super) fn solve_pairs(
    bench: &Bench,
    distance_mm: f64,
    draws: usize,
    stream: u64,
) -> Result<Vec<PairDrawn>, StudyError> {
    on_one_specimen(bench, draws, stream, |specimen, read, random| {
        let presses = random.pair(distance_mm)?;
        let (volts, slopes) = specimen.pressed(&bench.pad, &presses)?;
        let deviations = NoiseKind::Proportional.deviations(&volts, &specimen.rest);
        let reach_mm = REACH_MM * bench.scale;
        let bounds_mm = match slopes.bounds(&deviations) {
            Some(bounds) => bounds
                .iter()
                .map(|bound| bound.with_noise(share(SNR_DB)).mean_mm().min(reach_mm))
                .collect(),
            None => vec![reach_mm; presses.len()],
        };
        let contacts = read(&volts, random.seed());
        let score = Score::new(&presses, &contacts, WITHIN_MM * bench.scale);
        Ok(PairDrawn {
            detected: contacts.len(),
            resolved: score.is_right(),
            bounds_mm,
        })
    })
}

/// Draws single shapes on one specimen. Returns the number of contacts detected for each.
pub(super) fn solve_single_shapes(
    bench: &Bench,
    shape: SingleShape,
    draws: usize,
    stream: u64,
) -> Result<Vec<usize>, StudyError> {
    let pad = &bench.pad;
    on_one_specimen(bench, draws, stream, |specimen, read, random| {
        let placed = random.single(shape)?;
        let fields = specimen.touched(|point| match pad.touch_sign {
            TouchSign::Rise => placed.factor(point),
            TouchSign::Fall => 1.0 / placed.factor(point),
        })?;
        let volts = fields.voltages(&pad.protocol);
        Ok(read(&volts, random.seed()).len())
    })
}

/// Draws on one specimen. `draw` receives the specimen, and a function that returns the contacts detected in voltages with
/// noise from a seed.
fn on_one_specimen<T>(
    bench: &Bench,
    draws: usize,
    stream: u64,
    mut draw: impl FnMut(
        &Specimen,
        &dyn Fn(&[f64], u64) -> Vec<Contact>,
        &mut Draws,
    ) -> Result<T, StudyError>,
) -> Result<Vec<T>, StudyError> {
    let mut random = Draws::new(&bench.pad, bench.seed, stream);
    let specimen = Specimen::random(&bench.pad, &mut random)?;
    let instrument = instrument(&specimen);
    let rested = bench.rested(&instrument, random.seed())?;
    let read = |volts: &[f64], seed: u64| rested.contacts(&instrument.frame(volts, seed));
    (0..draws)
        .map(|_| draw(&specimen, &read, &mut random))
        .collect()
}

fn instrument(specimen: &Specimen) -> Instrument<'_> {
    Instrument {
        kind: NoiseKind::Proportional,
        snr_db: SNR_DB,
        rest: &specimen.rest,
    }
}

/// Results of the pairs at one distance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PairFindings {
    /// Between the centres, mm.
    pub distance_mm: f64,
    /// Pairs of which exactly two touches were detected, both near the truth.
    pub told_apart: Share,
    /// Pairs of which two touches were detected, at any place.
    pub counted_two: Share,
    /// Pairs of which one touch was detected.
    pub counted_one: Share,
    /// Bound of the mean error of place, mm.
    pub place_bound_mm: Spread,
}

impl PairFindings {
    pub(super) fn from_draws(distance_mm: f64, drawn: &[&PairDrawn]) -> Self {
        Self {
            distance_mm,
            told_apart: Share::counted(drawn, |draw| draw.resolved),
            counted_two: Share::counted(drawn, |draw| draw.detected == 2),
            counted_one: Share::counted(drawn, |draw| draw.detected == 1),
            place_bound_mm: Spread::new(drawn.iter().flat_map(|draw| draw.bounds_mm.clone())),
        }
    }
}

/// The least distance from which all pairs, up to the greatest distance, are resolved in at least [`RELIABLE`] of the draws,
/// mm.
pub(super) fn reliable_from_mm(pairs: &[PairFindings]) -> Option<f64> {
    pairs
        .iter()
        .rev()
        .take_while(|pair| pair.told_apart.share >= RELIABLE)
        .last()
        .map(|pair| pair.distance_mm)
}

/// Results of the single shapes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SingleShapeFindings {
    /// The shape.
    pub shape: SingleShape,
    /// Shapes detected as more than one touch.
    pub split: Share,
    /// Shapes not detected.
    pub missed: Share,
}

impl SingleShapeFindings {
    pub(super) fn from_counts(shape: SingleShape, detected: &[usize]) -> Self {
        Self {
            shape,
            split: Share::counted(detected, |count| *count > 1),
            missed: Share::counted(detected, |count| *count == 0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distance_is_reliable_if_all_beyond_it_are() {
        let pairs = |resolved: &[usize]| -> Vec<PairFindings> {
            resolved
                .iter()
                .enumerate()
                .map(|(index, hits)| PairFindings {
                    distance_mm: 10.0 + index as f64,
                    told_apart: Share::new(*hits, 100),
                    counted_two: Share::new(*hits, 100),
                    counted_one: Share::new(100 - hits, 100),
                    place_bound_mm: Spread::new([]),
                })
                .collect()
        };
        assert_eq!(reliable_from_mm(&pairs(&[10, 96, 90, 95, 100])), Some(13.0));
        assert_eq!(reliable_from_mm(&pairs(&[99, 99, 94])), None);
    }
}
