//! What presses taught about a pad that no model describes: how its readings change when it is pressed at each place.
//!
//! A measured skin can differ from its drawing so much that no finite-element pad fits it. Its maps, learned by
//! `calibrate::learn_maps`, then replace the model: the response table is interpolated from them.
//!
//! The changes of all presses lie close to a few directions, so a map holds coordinates instead of one value per channel.

use crate::types::PointMm;

/// Maps of a pad's readings over its outline, and what they leave unexplained.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedMaps {
    /// Number of presses from which the maps were learned.
    pub presses: usize,
    /// Places of the grid along x and y, two or more; the grid spans the pad's box.
    pub counts: [usize; 2],
    /// Directions by channels: relative changes (v - v0) / v0.
    pub directions: Vec<Vec<f64>>,
    /// Places (row by row, from the bottom left) by directions: a typical press at that place.
    pub responses: Vec<Vec<f64>>,
    /// Relative standard deviation of what the maps leave unexplained of a press, by channel, each channel by itself.
    pub deviations: Vec<f64>,
    /// Directions by channels that channels share in what the maps leave unexplained, each one standard deviation long.
    pub shared: Vec<Vec<f64>>,
}

/// Model error of maps from many presses, as a share of a frame's amplitude, and the number of presses that are many.
const LEAST_ERROR: f64 = 0.1;
const MANY_PRESSES: f64 = 500.0;
/// Model error of maps from few presses.
const MOST_ERROR: f64 = 0.3;

impl LearnedMaps {
    /// What the maps may miss of a press, as a share of its amplitude, beyond what they leave unexplained of most presses: the fewer
    /// presses, the more. Chosen on sums of measured presses of two skins.
    #[must_use]
    pub fn error_share(&self) -> f64 {
        let few = libm::sqrt(MANY_PRESSES / self.presses.max(1) as f64);
        (LEAST_ERROR * few).clamp(LEAST_ERROR, MOST_ERROR)
    }

    /// The relative changes by a typical press at a place (mm) of a pad of the given width and height; places beyond the pad's box
    /// respond like the nearest within.
    #[must_use]
    pub fn changes_at(&self, place_mm: PointMm, size_mm: [f64; 2]) -> Vec<f64> {
        let [columns, _] = self.counts;
        let [x, y] = [0, 1].map(|axis| {
            let last = (self.counts[axis] - 1) as f64;
            let step = place_mm[axis] / size_mm[axis] * last;
            cubic_weights(step.clamp(0.0, last), self.counts[axis])
        });
        let mut changes = vec![0.0; self.deviations.len()];
        for (direction, basis) in self.directions.iter().enumerate() {
            let mut coordinate = 0.0;
            for (row, by_row) in y {
                for (column, by_column) in x {
                    coordinate +=
                        by_row * by_column * self.responses[row * columns + column][direction];
                }
            }
            for (change, basis) in changes.iter_mut().zip(basis) {
                *change += coordinate * basis;
            }
        }
        changes
    }
}

/// The four nearest of `count` even steps and their weights in cubic convolution (Keys 1981, a = -1/2); beyond the ends, the last
/// value is repeated.
fn cubic_weights(step: f64, count: usize) -> [(usize, f64); 4] {
    let before = libm::floor(step);
    let t = step - before;
    let weights = [
        t * (t * (1.0 - 0.5 * t) - 0.5),
        1.0 + t * t * (1.5 * t - 2.5),
        t * (0.5 + t * (2.0 - 1.5 * t)),
        t * t * (0.5 * t - 0.5),
    ];
    [0, 1, 2, 3].map(|k| {
        let index = (before as usize + k).saturating_sub(1).min(count - 1);
        (index, weights[k])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One direction whose coordinate is x + 10 y, on a grid of 1 cm.
    fn tilted() -> LearnedMaps {
        let counts = [6, 4];
        let coordinate = |index: usize| (index % 6) as f64 + 10.0 * (index / 6) as f64;
        LearnedMaps {
            presses: 8,
            counts,
            directions: vec![vec![1.0, -2.0]],
            responses: (0..24).map(|index| vec![coordinate(index)]).collect(),
            deviations: vec![0.1; 2],
            shared: Vec::new(),
        }
    }

    #[test]
    fn a_plane_is_met_between_the_places() {
        let maps = tilted();
        for [x, y] in [[10.0, 10.0], [23.0, 17.0], [31.5, 12.5]] {
            let expected = 0.1 * x + y;
            let [first, second] = maps.changes_at([x, y], [50.0, 30.0])[..] else {
                panic!("two channels");
            };
            assert!((first - expected).abs() < 1e-9, "{first} for {expected}");
            assert!((second + 2.0 * expected).abs() < 1e-9);
        }
    }

    #[test]
    fn beyond_the_edge_the_nearest_place_answers() {
        let maps = tilted();
        let size_mm = [50.0, 30.0];
        assert_eq!(
            maps.changes_at([-4.0, 40.0], size_mm),
            maps.changes_at([0.0, 30.0], size_mm)
        );
    }
}
