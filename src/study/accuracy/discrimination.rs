//! Two-point discrimination: how near two touches may be and still be two, and whether one touch of another shape stays
//! one.

use serde::Serialize;

use super::Bench;
use super::draws::{Draws, Lone};
use super::noise::{Instrument, NoiseKind, share};
use super::score::{REACH_MM, Score};
use super::specimen::Specimen;
use super::stats::{Share, Spread};
use crate::pad::TouchSign;
use crate::study::StudyError;
use crate::types::Contact;

/// Noise in proportion to each reading, dB.
pub(super) const SNR_DB: f64 = 60.0;
/// Two touches are told apart if exactly two are seen, both within this distance of the truth, mm: well
/// within a finger's radius.
pub(super) const WITHIN_MM: f64 = 4.5;

/// Share of pairs told apart at which a distance is sure.
pub(super) const SURE: f64 = 0.95;

/// What two presses at a distance showed.
#[derive(Clone, Debug)]
pub(super) struct PairDrawn {
    seen: usize,
    told_apart: bool,
    /// The mean error of place that no unbiased method goes below, mm, one a touch.
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
        let score = Score::of(&presses, &contacts, WITHIN_MM * bench.scale);
        Ok(PairDrawn {
            seen: contacts.len(),
            told_apart: score.is_right(),
            bounds_mm,
        })
    })
}

/// Draws lone shapes on one specimen; returns how many contacts each showed.
pub(super) fn solve_lone(
    bench: &Bench,
    shape: Lone,
    draws: usize,
    stream: u64,
) -> Result<Vec<usize>, StudyError> {
    let pad = &bench.pad;
    on_one_specimen(bench, draws, stream, |specimen, read, random| {
        let laid = random.lone(shape)?;
        let fields = specimen.touched(|point| match pad.touch_sign {
            TouchSign::Rise => laid.factor(point),
            TouchSign::Fall => 1.0 / laid.factor(point),
        })?;
        let volts = fields.voltages(&pad.protocol);
        Ok(read(&volts, random.seed()).len())
    })
}

/// Draws on one specimen. Each draw is given the specimen and what tells the contacts of voltages, with noise of a seed.
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
    let specimen = Specimen::drawn(&bench.pad, &mut random)?;
    let instrument = instrument(&specimen);
    let rested = bench.sensing.rested(&instrument, random.seed())?;
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

/// What pairs at one distance gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PairFindings {
    /// From middle to middle, mm.
    pub distance_mm: f64,
    /// Pairs of which exactly two touches were seen, both near the truth.
    pub told_apart: Share,
    /// Pairs of which two touches were seen, wherever.
    pub counted_two: Share,
    /// Pairs of which one touch was seen.
    pub counted_one: Share,
    /// The mean error of place that no unbiased method goes below, mm.
    pub place_bound_mm: Spread,
}

impl PairFindings {
    pub(super) fn of(distance_mm: f64, drawn: &[&PairDrawn]) -> Self {
        Self {
            distance_mm,
            told_apart: Share::counted(drawn, |draw| draw.told_apart),
            counted_two: Share::counted(drawn, |draw| draw.seen == 2),
            counted_one: Share::counted(drawn, |draw| draw.seen == 1),
            place_bound_mm: Spread::of(drawn.iter().flat_map(|draw| draw.bounds_mm.clone())),
        }
    }
}

/// The least distance from which on, up to the greatest that was drawn, pairs are told apart in at least [`SURE`] of the
/// draws, mm.
pub(super) fn sure_from_mm(pairs: &[PairFindings]) -> Option<f64> {
    pairs
        .iter()
        .rev()
        .take_while(|pair| pair.told_apart.share >= SURE)
        .last()
        .map(|pair| pair.distance_mm)
}

/// What lone shapes gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoneFindings {
    /// Which shape.
    pub shape: Lone,
    /// Shapes of which more than one touch was seen.
    pub split: Share,
    /// Shapes of which none was seen.
    pub missed: Share,
}

impl LoneFindings {
    pub(super) fn of(shape: Lone, seen: &[usize]) -> Self {
        Self {
            shape,
            split: Share::counted(seen, |count| *count > 1),
            missed: Share::counted(seen, |count| *count == 0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distance_is_sure_if_all_beyond_it_are() {
        let pairs = |told: &[usize]| -> Vec<PairFindings> {
            told.iter()
                .enumerate()
                .map(|(index, hits)| PairFindings {
                    distance_mm: 10.0 + index as f64,
                    told_apart: Share::of(*hits, 100),
                    counted_two: Share::of(*hits, 100),
                    counted_one: Share::of(100 - hits, 100),
                    place_bound_mm: Spread::of([]),
                })
                .collect()
        };
        assert_eq!(sure_from_mm(&pairs(&[10, 96, 90, 95, 100])), Some(13.0));
        assert_eq!(sure_from_mm(&pairs(&[99, 99, 94])), None);
    }
}
