//! Locates presses with a map of each channel over the pad: the place whose expected readings fit best.
//!
//! With few presses, a map over two dimensions is learned far better than a function of two hundred voltages. The maps are one
//! Gaussian process over the places. The covariance of their residuals over the channels separates loose and correlated
//! channels from good ones. The place is the posterior mean over a grid. Residuals of neighbouring channels come from
//! one disturbance, so the likelihood counts as that of a few channels.

use faer::{Mat, Side};

use super::error::CalibrateError;
use super::features::{root, spread};
use super::presses::shuffled;
use super::process::{self, Hyperparameters, Process};

/// Grid places along each side of the box around the presses.
const GRID: usize = 45;
/// The grid reaches beyond the presses by this share of their box.
const MARGIN: f64 = 0.0125;
/// Number of independent readings that a frame counts as.
const EFFECTIVE_CHANNELS: f64 = 12.0;
/// Shrinkage of the residuals' covariance towards its diagonal: the first over the number of presses, plus the second.
const SHRINK: (f64, f64) = (10.0, 0.05);
/// Least residual variance of a channel, as a share of the mean.
const LEAST_VARIANCE: f64 = 1e-6;
/// Lengths (in deviations of the places) and noises tried for the maps.
const LENGTHS: [f64; 6] = [0.35, 0.5, 0.7, 1.1, 1.6, 2.2];
const NOISES: [f64; 5] = [0.003, 0.01, 0.03, 0.1, 0.3];
/// Most presses for the choice of length and noise.
const MOST_FOR_CHOICE: usize = 300;
/// Most presses for the residuals.
const MOST_FOR_RESIDUALS: usize = 1000;

/// Maps of all channels.
#[derive(Clone, Debug)]
pub(super) struct Maps {
    power: f64,
    /// Grid places by 2, mm.
    grid: Mat<f64>,
    /// Channels by independent directions.
    whitening: Mat<f64>,
    /// Expected readings at the grid, whitened.
    expected: Mat<f64>,
    /// Variance of maps and noise at the grid, over the prior's.
    variance: Vec<f64>,
}

impl Maps {
    /// Learns the maps of the changes' signed roots.
    pub(super) fn fit(
        power: f64,
        changes: &Mat<f64>,
        places: &Mat<f64>,
    ) -> Result<Self, CalibrateError> {
        let values = Mat::from_fn(changes.nrows(), changes.ncols(), |r, c| {
            root(changes[(r, c)], power)
        });
        let hyper = choose(&values, places)?;
        let some = subset(places.nrows(), MOST_FOR_RESIDUALS);
        let (near, shown) = (rows(places, &some), rows(&values, &some));
        let left_out =
            process::leave_one_out(&process::squared_distances(&near, &near), &shown, hyper)?;
        let whitening = whitening(&left_out)?;
        let maps = Process::fit(places.clone(), &values, hyper)?;
        let grid = grid(places, GRID);
        let variance = maps.variance(&grid)?;
        Ok(Self {
            power,
            expected: maps.predict(&grid) * &whitening,
            variance: variance.iter().map(|v| v + hyper.noise).collect(),
            grid,
            whitening,
        })
    }

    /// Predicts the places of presses, mm: presses by 2.
    pub(super) fn predict(&self, changes: &Mat<f64>) -> Mat<f64> {
        let values = Mat::from_fn(changes.nrows(), changes.ncols(), |r, c| {
            root(changes[(r, c)], self.power)
        });
        let whitened = values * &self.whitening;
        let distances2 = process::squared_distances(&self.expected, &whitened);
        let share = EFFECTIVE_CHANNELS / self.whitening.nrows() as f64;
        let mut places = Mat::zeros(changes.nrows(), 2);
        let mut logs = vec![0.0; self.variance.len()];
        for press in 0..changes.nrows() {
            for (place, (log, variance)) in logs.iter_mut().zip(&self.variance).enumerate() {
                *log = -0.5 * share * distances2[(place, press)] / variance
                    - 0.5 * EFFECTIVE_CHANNELS * libm::log(*variance);
            }
            let highest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let mut sums = [0.0; 3];
            for (place, log) in logs.iter().enumerate() {
                let weight = libm::exp(log - highest);
                sums[0] += weight;
                sums[1] += weight * self.grid[(place, 0)];
                sums[2] += weight * self.grid[(place, 1)];
            }
            places[(press, 0)] = sums[1] / sums[0];
            places[(press, 1)] = sums[2] / sums[0];
        }
        places
    }
}

/// The length and noise with the highest likelihood of the left-out readings, each channel with its own variance.
pub(super) fn choose(
    values: &Mat<f64>,
    places: &Mat<f64>,
) -> Result<Hyperparameters, CalibrateError> {
    let some = subset(places.nrows(), MOST_FOR_CHOICE);
    let (places, values) = (rows(places, &some), rows(values, &some));
    let distances2 = process::squared_distances(&places, &places);
    let unit = spread(&places);
    let mut best: Option<(f64, Hyperparameters)> = None;
    for length in LENGTHS {
        for noise in NOISES {
            let hyper = Hyperparameters {
                length: length * unit,
                noise,
            };
            let left_out = process::leave_one_out(&distances2, &values, hyper)?;
            let count = left_out.variance.len() as f64;
            let loss = mean(
                (0..values.ncols())
                    .map(|channel| left_out.scale(channel))
                    .filter(|v| *v > 0.0)
                    .map(libm::log),
            ) + left_out.variance.iter().map(|v| libm::log(*v)).sum::<f64>() / count;
            if best.as_ref().is_none_or(|(least, _)| loss < *least) {
                best = Some((loss, hyper));
            }
        }
    }
    best.map(|(_, hyper)| hyper).ok_or(CalibrateError::Alike)
}

/// The map (channels by directions) after which standardised residuals are independent with variance 1.
fn whitening(left_out: &process::LeaveOneOut) -> Result<Mat<f64>, CalibrateError> {
    let (count, channels) = (left_out.residuals.nrows(), left_out.residuals.ncols());
    let standard = Mat::from_fn(count, channels, |r, c| {
        left_out.residuals[(r, c)] / libm::sqrt(left_out.variance[r] * count as f64)
    });
    let mut covariance = standard.transpose() * &standard;
    let trace: f64 = (0..channels).map(|c| covariance[(c, c)]).sum();
    let floor = (LEAST_VARIANCE * trace / channels as f64).max(f64::MIN_POSITIVE);
    let shrink = (SHRINK.0 / count as f64 + SHRINK.1).min(0.9);
    for column in 0..channels {
        for row in 0..channels {
            if row == column {
                covariance[(row, column)] = covariance[(row, column)].max(floor);
            } else {
                covariance[(row, column)] *= 1.0 - shrink;
            }
        }
    }
    let eigen = covariance
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| CalibrateError::Alike)?;
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    Ok(Mat::from_fn(channels, channels, |row, d| {
        vectors[(row, d)] / libm::sqrt(values[d].max(floor))
    }))
}

/// Places of a grid over the box around the presses, `side` along each side: side² by 2, mm.
pub(super) fn grid(places: &Mat<f64>, side: usize) -> Mat<f64> {
    let [x, y] = [0, 1].map(|axis| {
        let values = || places.col(axis).iter().copied();
        let (low, high) = (
            values().fold(f64::INFINITY, f64::min),
            values().fold(f64::NEG_INFINITY, f64::max),
        );
        let margin = MARGIN * (high - low);
        (low - margin, high - low + 2.0 * margin)
    });
    Mat::from_fn(side * side, 2, |place, axis| {
        let ((low, length), step) = match axis {
            0 => (x, place / side),
            _ => (y, place % side),
        };
        low + length * step as f64 / (side - 1) as f64
    })
}

/// Indices of at most `most` presses, shuffled.
pub(super) fn subset(count: usize, most: usize) -> Vec<usize> {
    let mut some = shuffled(count);
    some.truncate(most);
    some
}

/// Some rows of a matrix.
pub(super) fn rows(matrix: &Mat<f64>, which: &[usize]) -> Mat<f64> {
    Mat::from_fn(which.len(), matrix.ncols(), |r, c| matrix[(which[r], c)])
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_press_between_the_learned_ones_is_located() {
        // Six channels, each a bump over a 60 mm pad; one of them is dead.
        let reading = |x: f64, y: f64, channel: usize| {
            if channel == 5 {
                return 0.0;
            }
            let (cx, cy) = (
                [10.0, 50.0, 30.0, 5.0, 55.0][channel],
                [10.0, 12.0, 50.0, 45.0, 40.0][channel],
            );
            3.0 * libm::exp(-((x - cx) * (x - cx) + (y - cy) * (y - cy)) / 900.0)
        };
        let places = Mat::from_fn(64, 2, |i, axis| {
            if axis == 0 {
                (i % 8) as f64 * 8.5
            } else {
                (i / 8) as f64 * 8.5
            }
        });
        let changes = Mat::from_fn(64, 6, |i, c| reading(places[(i, 0)], places[(i, 1)], c));
        let maps = Maps::fit(0.75, &changes, &places).expect("sound");
        for (x, y) in [(20.0, 20.0), (33.0, 41.0), (12.0, 50.0), (47.0, 30.0)] {
            let press = Mat::from_fn(1, 6, |_, c| reading(x, y, c));
            let found = maps.predict(&press);
            let error = libm::hypot(found[(0, 0)] - x, found[(0, 1)] - y);
            assert!(error < 2.0, "({x}, {y}) is off by {error} mm");
        }
    }
}
