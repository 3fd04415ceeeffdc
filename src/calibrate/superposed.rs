//! Locates several touches of a pad from maps that were learned from single presses.
//!
//! The changes of two touches are close to the sum of the changes of each. A map of each channel over the pad is learned from
//! the signed roots of single presses; sums of map values, taken back from the roots, are the expected readings of several
//! touches. What those sums miss is measured on sums of the presses themselves, each expected from the others: its covariance
//! decides how much a reading counts. Two touches are searched over all pairs of a coarse grid, a third over the whole grid with
//! two given; then each is placed at its posterior mean on a fine grid while the others stay.

use faer::Mat;

use super::component_maps::{ComponentSpec, Projection, whitening};
use super::error::CalibrateError;
use super::features::{root, spread};
use super::maps::{choose, grid, rows, subset};
use super::presses::{Presses, shuffled};
use super::process::{self, Process};
use crate::types::PointMm;

/// Most touches that are located.
pub const MOST_PLACES: usize = 3;
/// Fine grid places along each side of the box around the presses; every [`COARSE_STEP`]th is on the coarse grid.
const FINE: usize = 65;
const COARSE_STEP: usize = 4;
/// Half of the window of the fine search, fine grid steps: 7.5 mm on a pad of 80 mm.
const WINDOW: usize = 6;
/// Pairs closer than this many coarse steps are one touch.
const LEAST_APART: f64 = 2.0;
/// The components that are compared.
const SPEC: ComponentSpec = ComponentSpec {
    power: 0.6,
    unit: false,
    components: 40,
    limit: Some(3.0),
};
/// Sums of presses from which the covariance is learned.
const SUMS: usize = 800;
/// Most presses that are expected from the others.
const MOST_LEFT_OUT: usize = 800;
/// Power of the likelihood where places are averaged.
const LIKELIHOOD_POWER: f64 = 0.5;
/// Best pairs from which three touches are searched, and rounds in which each touch is searched again.
const STARTS: usize = 8;
const ROUNDS: usize = 3;
/// Rows of candidates that are projected at once.
const BATCH: usize = 4096;

/// Maps for a given number of touches.
#[derive(Clone, Debug)]
pub struct SuperposedMaps {
    count: usize,
    /// Fine grid places by 2, mm.
    grid: Mat<f64>,
    /// Expected changes at the fine grid: places by channels.
    expected: Mat<f64>,
    projection: Projection,
    /// Components by independent directions.
    whitening: Mat<f64>,
    /// Pairs of fine grid places, all on the coarse grid, ...
    pairs: Vec<[usize; 2]>,
    /// ... and their whitened components. For three touches, `pairs` are starts only.
    pair_values: Mat<f64>,
}

impl SuperposedMaps {
    /// Learns from single presses; `count` is 2 or 3.
    ///
    /// # Errors
    /// See [`CalibrateError`].
    pub fn fit(presses: &Presses, count: usize) -> Result<Self, CalibrateError> {
        let order = shuffled(presses.len());
        let (changes, places) = (presses.changes(&order), presses.places(&order));
        let values = Mat::from_fn(changes.nrows(), changes.ncols(), |r, c| {
            root(changes[(r, c)], SPEC.power)
        });
        let hyper = choose(&values, &places)?;
        let few = subset(places.nrows(), MOST_LEFT_OUT);
        let (near, shown) = (rows(&places, &few), rows(&values, &few));
        let left_out =
            process::leave_one_out(&process::squared_distances(&near, &near), &shown, hyper)?;
        let foreseen = unrooted(&(&shown - &left_out.residuals));
        let measured = rows(&changes, &few);
        let sets = sets(few.len(), count, &near);
        let (measured, foreseen) = (sums(&measured, &sets), sums(&foreseen, &sets));
        let (projection, components) = Projection::fit(SPEC, &measured)?;
        let residuals = components - projection.apply(&foreseen);
        let whitening = scaled_whitening(&residuals)?;
        let grid = grid(&places, FINE);
        let expected = unrooted(&Process::fit(places, &values, hyper)?.predict(&grid));
        let mut maps = Self {
            count,
            grid,
            expected,
            projection,
            whitening,
            pairs: Vec::new(),
            pair_values: Mat::zeros(0, 0),
        };
        maps.add_pairs();
        Ok(maps)
    }

    /// The places of the touches of each row of changes, mm.
    ///
    /// # Panics
    /// If there are other channels than were learned from.
    #[must_use]
    pub fn locate(&self, changes: &Mat<f64>) -> Vec<Vec<PointMm>> {
        let values = self.projection.apply(changes) * &self.whitening;
        (0..values.nrows())
            .map(|row| {
                let target: Vec<f64> = (0..values.ncols()).map(|c| values[(row, c)]).collect();
                self.locate_one(&target)
            })
            .collect()
    }

    fn locate_one(&self, target: &[f64]) -> Vec<PointMm> {
        let pair_costs = costs(&self.pair_values, target);
        let mut best: Vec<usize> = (0..pair_costs.len()).collect();
        best.sort_by(|a, b| pair_costs[*a].total_cmp(&pair_costs[*b]));
        let starts = if self.count == 2 { 1 } else { STARTS };
        let coarse = coarse_places();
        let mut found: Option<(f64, Vec<usize>)> = None;
        for pair in best.into_iter().take(starts) {
            let mut places = self.pairs[pair].to_vec();
            while places.len() < self.count {
                let costs = self.costs_with(&places, &coarse, target);
                places.push(coarse[least(&costs)]);
            }
            let mut cost = f64::INFINITY;
            if self.count > 2 {
                for turn in 0..ROUNDS * self.count {
                    let which = turn % self.count;
                    let others = without(&places, which);
                    let costs = self.costs_with(&others, &coarse, target);
                    let index = least(&costs);
                    (places[which], cost) = (coarse[index], costs[index]);
                }
            }
            if found.as_ref().is_none_or(|(least, _)| cost < *least) {
                found = Some((cost, places));
            }
        }
        self.refine(found.map(|(_, places)| places).unwrap_or_default(), target)
    }

    /// Moves each touch to its posterior mean around where it is, the others staying.
    fn refine(&self, mut places: Vec<usize>, target: &[f64]) -> Vec<PointMm> {
        let mut located = vec![[0.0; 2]; places.len()];
        for turn in 0..ROUNDS * places.len() {
            let which = turn % places.len();
            let window = window(places[which]);
            let costs = self.costs_with(&without(&places, which), &window, target);
            places[which] = window[least(&costs)];
            located[which] = self.mean_place(&window, &costs);
        }
        located
    }

    /// The posterior mean over candidates.
    fn mean_place(&self, candidates: &[usize], costs: &[f64]) -> PointMm {
        let lowest = costs.iter().copied().fold(f64::INFINITY, f64::min);
        let mut sums = [0.0; 3];
        for (place, cost) in candidates.iter().zip(costs) {
            let weight = libm::exp(-0.5 * LIKELIHOOD_POWER * (cost - lowest));
            sums[0] += weight;
            sums[1] += weight * self.grid[(*place, 0)];
            sums[2] += weight * self.grid[(*place, 1)];
        }
        [sums[1] / sums[0], sums[2] / sums[0]]
    }

    /// The squared deviation of a frame from touches at given places and one at each candidate.
    fn costs_with(&self, given: &[usize], candidates: &[usize], target: &[f64]) -> Vec<f64> {
        let changes = Mat::from_fn(candidates.len(), self.expected.ncols(), |row, channel| {
            given
                .iter()
                .chain([&candidates[row]])
                .map(|place| self.expected[(*place, channel)])
                .sum()
        });
        costs(&(self.projection.apply(&changes) * &self.whitening), target)
    }

    fn add_pairs(&mut self) {
        let coarse = coarse_places();
        for (index, first) in coarse.iter().enumerate() {
            for second in &coarse[index + 1..] {
                let steps = |place: usize| [(place / FINE) as f64, (place % FINE) as f64];
                let ([a, b], [c, d]) = (steps(*first), steps(*second));
                if libm::hypot(a - c, b - d) >= LEAST_APART * COARSE_STEP as f64 {
                    self.pairs.push([*first, *second]);
                }
            }
        }
        let mut values = Mat::zeros(self.pairs.len(), self.whitening.ncols());
        for (batch, pairs) in self.pairs.chunks(BATCH).enumerate() {
            let changes = Mat::from_fn(pairs.len(), self.expected.ncols(), |row, channel| {
                let [first, second] = pairs[row];
                self.expected[(first, channel)] + self.expected[(second, channel)]
            });
            let some = self.projection.apply(&changes) * &self.whitening;
            for column in 0..some.ncols() {
                for row in 0..some.nrows() {
                    values[(batch * BATCH + row, column)] = some[(row, column)];
                }
            }
        }
        self.pair_values = values;
    }
}

/// Squared distances of rows to a vector.
fn costs(rows: &Mat<f64>, target: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; rows.nrows()];
    for (column, wanted) in target.iter().enumerate() {
        for (sum, value) in sums.iter_mut().zip(rows.col(column).iter()) {
            *sum += (value - wanted) * (value - wanted);
        }
    }
    sums
}

fn least(costs: &[f64]) -> usize {
    let best = costs.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
    best.map_or(0, |(index, _)| index)
}

fn without(places: &[usize], which: usize) -> Vec<usize> {
    let others = places
        .iter()
        .enumerate()
        .filter(|(index, _)| *index != which);
    others.map(|(_, place)| *place).collect()
}

/// Indices of the coarse grid's places in the fine grid.
fn coarse_places() -> Vec<usize> {
    (0..FINE * FINE)
        .filter(|place| {
            [place / FINE, place % FINE]
                .iter()
                .all(|step| step.is_multiple_of(COARSE_STEP))
        })
        .collect()
}

/// The fine grid places around one.
fn window(place: usize) -> Vec<usize> {
    let around = |at: usize| at.saturating_sub(WINDOW)..=(at + WINDOW).min(FINE - 1);
    around(place / FINE)
        .flat_map(|x| around(place % FINE).map(move |y| x * FINE + y))
        .collect()
}

/// Changes from their signed roots.
fn unrooted(values: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(values.nrows(), values.ncols(), |r, c| {
        root(values[(r, c)], 1.0 / SPEC.power)
    })
}

/// Sets of different presses, in a fixed pseudo-random order; presses of a set are not at one place.
fn sets(presses: usize, count: usize, places: &Mat<f64>) -> Vec<Vec<usize>> {
    let mut drawn = Vec::new();
    for round in 0..SUMS.div_ceil(presses) {
        // Each press meets others at another distance in each round.
        for first in 0..presses {
            let step = 1 + (round * 7 + first) % (presses / count).max(1);
            let set: Vec<usize> = (0..count).map(|k| (first + k * step) % presses).collect();
            let apart = |a: usize, b: usize| {
                let [dx, dy] = [0, 1].map(|axis| places[(a, axis)] - places[(b, axis)]);
                libm::hypot(dx, dy) > 0.5 * spread(places)
            };
            if (1..count).all(|k| (0..k).all(|j| apart(set[k], set[j]))) {
                drawn.push(set);
            }
        }
    }
    drawn
}

/// The sum of the rows of each set.
fn sums(rows: &Mat<f64>, sets: &[Vec<usize>]) -> Mat<f64> {
    Mat::from_fn(sets.len(), rows.ncols(), |set, column| {
        sets[set].iter().map(|row| rows[(*row, column)]).sum()
    })
}

/// The map after which residuals are independent with variance 1.
fn scaled_whitening(residuals: &Mat<f64>) -> Result<Mat<f64>, CalibrateError> {
    let (count, components) = (residuals.nrows(), residuals.ncols());
    if count == 0 {
        return Err(CalibrateError::Alike);
    }
    let deviations: Vec<f64> = (0..components)
        .map(|c| libm::sqrt(residuals.col(c).squared_norm_l2() / count as f64))
        .map(|deviation| deviation.max(f64::MIN_POSITIVE))
        .collect();
    let standard = Mat::from_fn(count, components, |r, c| residuals[(r, c)] / deviations[c]);
    let directions = whitening(&standard)?;
    Ok(Mat::from_fn(components, directions.ncols(), |r, c| {
        directions[(r, c)] / deviations[r]
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::Press;

    fn changes_at(places: &[PointMm]) -> Vec<f64> {
        (0..16)
            .map(|channel| {
                let (cx, cy) = (f64::from(channel % 4) * 25.0, f64::from(channel / 4) * 25.0);
                let bump =
                    |[x, y]: &PointMm| libm::exp(-((x - cx).powi(2) + (y - cy).powi(2)) / 800.0);
                400.0 * places.iter().map(bump).sum::<f64>()
            })
            .collect()
    }

    #[test]
    fn two_and_three_touches_are_located_from_single_presses() {
        let list = (0..120)
            .map(|i| {
                let at = |root: f64| 75.0 * (0.5 + f64::from(i) * root).fract();
                let place_mm = [at(0.754_877_666), at(0.569_840_29)];
                Press {
                    place_mm,
                    modelled: None,
                    changes: changes_at(&[place_mm]),
                }
            })
            .collect();
        let presses = Presses::new("p", list).expect("spread");
        for truth in [
            vec![[15.0, 20.0], [60.0, 50.0]],
            vec![[30.0, 30.0], [50.0, 32.0]],
            vec![[12.0, 60.0], [40.0, 15.0], [66.0, 55.0]],
        ] {
            let maps = SuperposedMaps::fit(&presses, truth.len()).expect("sound");
            let changes = changes_at(&truth);
            let found = maps.locate(&Mat::from_fn(1, 16, |_, c| changes[c]));
            for place in &truth {
                let nearest = found[0]
                    .iter()
                    .map(|at| libm::hypot(at[0] - place[0], at[1] - place[1]))
                    .fold(f64::INFINITY, f64::min);
                assert!(nearest < 3.0, "{place:?} is off by {nearest} mm: {found:?}");
            }
        }
    }
}
