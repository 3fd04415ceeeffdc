//! The rival of a new finger: those that are down have moved otherwise than expected.
//!
//! A finger that has just begun to slide, or turns, is not where its readings were expected from. What it changes looks much like another
//! finger in the few readings of some parts, but a small move of its own explains them better.

use nalgebra::{DMatrix, DVector};

use super::readings::{MODEL_ERROR, PartReadings};

/// Standard deviations of what is not expected of a finger within a frame: its move along x and y, mm, and the change of its log radius and
/// of its strength.
const SPREAD: [f64; 4] = [4.0, 4.0, 0.2, 0.2];

/// The squared deviations of readings that the best moves of the fingers that are down leave, in the first order. `slopes` are how their
/// responses change with x, y, log radius and strength: four for each finger, one value per channel of the pad.
pub(super) fn rest_of_moves<'a>(
    slopes: &[Vec<f32>],
    parts: impl Iterator<Item = &'a PartReadings>,
) -> f64 {
    let spreads = SPREAD.iter().cycle().take(slopes.len());
    let priors = spreads.map(|spread| 1.0 / (spread * spread));
    let mut matrix = DMatrix::from_diagonal(&DVector::from_iterator(slopes.len(), priors));
    let mut along = DVector::zeros(slopes.len());
    let mut energy = 0.0;
    for (channel, change, precision) in parts.flat_map(PartReadings::iter) {
        // As in the fit of a finger.
        let model = MODEL_ERROR * change;
        let precision = precision / (1.0 + precision * model * model);
        let slope = DVector::from_fn(slopes.len(), |k, _| f64::from(slopes[k][channel]));
        energy += precision * change * change;
        along.axpy(precision * change, &slope, 1.0);
        matrix.ger(precision, &slope, &slope, 1.0);
    }
    let explained = matrix
        .cholesky()
        .map_or(0.0, |factors| along.dot(&factors.solve(&along)));
    energy - explained
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHANNELS: usize = 40;

    fn slopes() -> Vec<Vec<f32>> {
        (0..4)
            .map(|k| {
                let slope = |channel: usize| 1e-2 * ((k + 1) as f32 * channel as f32).sin();
                (0..CHANNELS).map(slope).collect()
            })
            .collect()
    }

    fn readings(change: impl Fn(usize) -> f32) -> PartReadings {
        PartReadings {
            first: 0,
            changes: (0..CHANNELS).map(change).collect(),
            precisions: vec![1e6; CHANNELS],
        }
    }

    #[test]
    fn a_move_explains_what_it_changes_and_little_of_what_it_does_not() {
        let slopes = slopes();
        let moved = readings(|channel| 2.0 * slopes[0][channel] - slopes[1][channel]);
        let other = readings(|channel| 0.02 * (channel as f32 * 0.7).cos());
        let nothing = vec![];
        for (readings, most_share, least_share) in [(moved, 0.01, 0.0), (other, 1.0, 0.7)] {
            let energy = rest_of_moves(&nothing, [&readings].into_iter());
            let rest = rest_of_moves(&slopes, [&readings].into_iter());
            assert!(energy > 1000.0, "{energy}");
            let share = rest / energy;
            assert!((least_share..most_share).contains(&share), "{share}");
        }
    }
}
