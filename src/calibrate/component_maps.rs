//! Locates presses with maps of the principal components of a frame over the pad.
//!
//! With few presses the readings of two hundred channels span a few directions that depend on the place; the rest is noise that
//! channels share. Each component has a Gaussian process over the place, with its own length and noise. The covariance of the
//! components' left-out residuals is learned, and widened by what each map does not know at a place, so that a place far from
//! every press neither attracts nor excludes a reading. The result is the posterior mean over a grid.

use faer::{Mat, Side};

use super::error::CalibrateError;
use super::features::{root, spread};
use super::maps::grid;
use super::process::{self, Hyperparameters, Process};

/// Lengths (in deviations of the places) and noises tried for each component.
const LENGTHS: [f64; 6] = [0.3, 0.5, 0.8, 1.3, 2.1, 3.4];
const NOISES: [f64; 6] = [0.01, 0.04, 0.15, 0.6, 2.5, 10.0];
/// Grid places along each side of the box around the presses.
const GRID: usize = 29;
/// Shrinkage of the residuals' covariance towards its diagonal: the first over the number of presses, plus the second.
const SHRINK: (f64, f64) = (3.0, 0.02);
/// Standardised residuals count at most this much: one odd press must not shape the covariance.
const MOST_RESIDUAL: f64 = 4.0;
/// Power of the likelihood: the components' errors are not quite independent.
const LIKELIHOOD_POWER: f64 = 0.4;
/// Least eigenvalue of the residuals' correlation, and least variance of a channel as a share of the mean.
const LEAST_VARIANCE: f64 = 1e-6;

/// How the components are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ComponentSpec {
    /// Power of the signed root of a change.
    pub power: f64,
    /// Whether each press is scaled to unit norm.
    pub unit: bool,
    /// Most components.
    pub components: usize,
    /// Compresses changes beyond this many deviations of their channel, if given.
    pub limit: Option<f64>,
}

/// Maps of the components.
#[derive(Clone, Debug)]
pub(super) struct ComponentMaps {
    projection: Projection,
    /// Grid places by 2, mm.
    grid: Mat<f64>,
    /// Whitened expected components: grid by directions.
    expected: Mat<f64>,
    /// One over the deviation of each component at the grid: grid by components.
    inverse_deviation: Mat<f64>,
    /// Logarithm of the variances' product at the grid.
    log_variance: Vec<f64>,
    /// Components by independent directions.
    whitening: Mat<f64>,
}

impl ComponentMaps {
    /// Learns from changes (presses by channels) at places (presses by 2).
    pub(super) fn fit(
        spec: ComponentSpec,
        changes: &Mat<f64>,
        places: &Mat<f64>,
    ) -> Result<Self, CalibrateError> {
        let (projection, values) = Projection::fit(spec, changes)?;
        let chosen = choose(&values, places)?;
        let grid = grid(places, GRID);
        let (count, components) = (values.nrows(), values.ncols());
        let mut expected = Mat::zeros(grid.nrows(), components);
        let mut variance = Mat::zeros(grid.nrows(), components);
        let mut standard = Mat::zeros(count, components);
        let distances2 = process::squared_distances(places, places);
        for hyper in distinct(&chosen) {
            let which: Vec<usize> = (0..components).filter(|k| chosen[*k] == hyper).collect();
            let some = Mat::from_fn(count, which.len(), |r, c| values[(r, which[c])]);
            let left_out = process::leave_one_out(&distances2, &some, hyper)?;
            let maps = Process::fit(places.clone(), &some, hyper)?;
            let predicted = maps.predict(&grid);
            let unknown = maps.variance(&grid)?;
            for (column, component) in which.into_iter().enumerate() {
                let scale = left_out.scale(column).max(f64::MIN_POSITIVE);
                for press in 0..count {
                    let deviation = libm::sqrt(left_out.variance[press] * scale);
                    standard[(press, component)] = (left_out.residuals[(press, column)]
                        / deviation)
                        .clamp(-MOST_RESIDUAL, MOST_RESIDUAL);
                }
                for place in 0..grid.nrows() {
                    expected[(place, component)] = predicted[(place, column)];
                    variance[(place, component)] = (unknown[place] + hyper.noise) * scale;
                }
            }
        }
        let whitening = whitening(&standard)?;
        let inverse_deviation = Mat::from_fn(grid.nrows(), components, |r, c| {
            1.0 / libm::sqrt(variance[(r, c)])
        });
        let weighted = Mat::from_fn(grid.nrows(), components, |r, c| {
            expected[(r, c)] * inverse_deviation[(r, c)]
        });
        Ok(Self {
            expected: weighted * &whitening,
            log_variance: (0..grid.nrows())
                .map(|r| (0..components).map(|c| libm::log(variance[(r, c)])).sum())
                .collect(),
            projection,
            grid,
            inverse_deviation,
            whitening,
        })
    }

    /// Predicts the places of presses, mm: presses by 2.
    pub(super) fn predict(&self, changes: &Mat<f64>) -> Mat<f64> {
        let values = self.projection.apply(changes);
        let mut places = Mat::zeros(changes.nrows(), 2);
        for press in 0..changes.nrows() {
            let weighted = Mat::from_fn(self.grid.nrows(), values.ncols(), |r, c| {
                values[(press, c)] * self.inverse_deviation[(r, c)]
            });
            let off = weighted * &self.whitening - &self.expected;
            let mut logs = self.log_variance.clone();
            for column in 0..off.ncols() {
                for (log, value) in logs.iter_mut().zip(off.col(column).iter()) {
                    *log += value * value;
                }
            }
            let least = logs.iter().copied().fold(f64::INFINITY, f64::min);
            let mut sums = [0.0; 3];
            for (place, log) in logs.iter().enumerate() {
                let weight = libm::exp(-0.5 * LIKELIHOOD_POWER * (log - least));
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

/// From changes to components of unit variance.
#[derive(Clone, Debug)]
pub(super) struct Projection {
    spec: ComponentSpec,
    mean: Vec<f64>,
    deviation: Vec<f64>,
    /// Mean after the limit.
    limited_mean: Vec<f64>,
    /// Channels by components.
    basis: Mat<f64>,
}

impl Projection {
    /// The projection and the components of the presses.
    pub(super) fn fit(
        spec: ComponentSpec,
        changes: &Mat<f64>,
    ) -> Result<(Self, Mat<f64>), CalibrateError> {
        let (count, channels) = (changes.nrows(), changes.ncols());
        let shaped = shape(spec, changes);
        let (mean, deviation) = moments(&shaped);
        let whole = deviation.iter().sum::<f64>() / channels as f64;
        let floor = (LEAST_VARIANCE * whole).max(f64::MIN_POSITIVE);
        let mut projection = Self {
            spec,
            mean,
            deviation: deviation.iter().map(|d| d.max(floor)).collect(),
            limited_mean: vec![0.0; channels],
            basis: Mat::identity(channels, channels),
        };
        let limited = projection.apply(changes);
        projection.limited_mean = moments(&limited).0;
        let centred = projection.apply(changes);
        let covariance = centred.transpose() * &centred * faer::Scale(1.0 / count as f64);
        let eigen = covariance
            .self_adjoint_eigen(Side::Lower)
            .map_err(|_| CalibrateError::Alike)?;
        let (vectors, values) = (eigen.U(), eigen.S().column_vector());
        let largest = values[channels - 1].max(f64::MIN_POSITIVE);
        let kept: Vec<usize> = (0..channels)
            .rev()
            .take(spec.components)
            .filter(|k| values[*k] > 1e-9 * largest)
            .collect();
        projection.basis = Mat::from_fn(channels, kept.len(), |row, column| {
            vectors[(row, kept[column])] / libm::sqrt(values[kept[column]])
        });
        let components = centred * &projection.basis;
        Ok((projection, components))
    }

    pub(super) fn apply(&self, changes: &Mat<f64>) -> Mat<f64> {
        let shaped = shape(self.spec, changes);
        let limited = Mat::from_fn(shaped.nrows(), shaped.ncols(), |r, c| {
            let standard = (shaped[(r, c)] - self.mean[c]) / self.deviation[c];
            let limited = match self.spec.limit {
                Some(limit) => limit * libm::tanh(standard / limit),
                None => standard,
            };
            limited - self.limited_mean[c]
        });
        limited * &self.basis
    }
}

/// Signed roots of the changes, with unit norm if the specification says so.
fn shape(spec: ComponentSpec, changes: &Mat<f64>) -> Mat<f64> {
    let mut shaped = Mat::from_fn(changes.nrows(), changes.ncols(), |r, c| {
        root(changes[(r, c)], spec.power)
    });
    if spec.unit {
        for row in 0..shaped.nrows() {
            let norm = process::norm(&shaped, row).max(f64::MIN_POSITIVE);
            for column in 0..shaped.ncols() {
                shaped[(row, column)] /= norm;
            }
        }
    }
    shaped
}

/// Mean and standard deviation of each column.
fn moments(values: &Mat<f64>) -> (Vec<f64>, Vec<f64>) {
    let count = values.nrows() as f64;
    (0..values.ncols())
        .map(|c| {
            let mean = values.col(c).iter().sum::<f64>() / count;
            let squares: f64 = values.col(c).iter().map(|v| (v - mean) * (v - mean)).sum();
            (mean, libm::sqrt(squares / count))
        })
        .unzip()
}

/// For each component the length and noise with the highest likelihood of the left-out values.
pub(super) fn choose(
    values: &Mat<f64>,
    places: &Mat<f64>,
) -> Result<Vec<Hyperparameters>, CalibrateError> {
    let distances2 = process::squared_distances(places, places);
    let unit = spread(places);
    let mut best: Vec<Option<(f64, Hyperparameters)>> = vec![None; values.ncols()];
    for length in LENGTHS {
        for noise in NOISES {
            let hyper = Hyperparameters {
                length: length * unit,
                noise,
            };
            let left_out = process::leave_one_out(&distances2, values, hyper)?;
            let spread: f64 = left_out.variance.iter().map(|v| libm::log(*v)).sum();
            let common = spread / left_out.variance.len() as f64;
            for (component, best) in best.iter_mut().enumerate() {
                let loss = libm::log(left_out.scale(component).max(f64::MIN_POSITIVE)) + common;
                if best.is_none_or(|(least, _)| loss < least) {
                    *best = Some((loss, hyper));
                }
            }
        }
    }
    best.into_iter()
        .map(|best| best.map(|(_, hyper)| hyper).ok_or(CalibrateError::Alike))
        .collect()
}

pub(super) fn distinct(chosen: &[Hyperparameters]) -> Vec<Hyperparameters> {
    let mut distinct: Vec<Hyperparameters> = Vec::new();
    for hyper in chosen {
        if !distinct.contains(hyper) {
            distinct.push(*hyper);
        }
    }
    distinct
}

/// The map (components by directions) after which standardised residuals are independent with variance 1.
pub(super) fn whitening(standard: &Mat<f64>) -> Result<Mat<f64>, CalibrateError> {
    let (count, components) = (standard.nrows() as f64, standard.ncols());
    let mut correlation = standard.transpose() * standard * faer::Scale(1.0 / count);
    let shrink = (SHRINK.0 / count + SHRINK.1).min(0.9);
    for column in 0..components {
        for row in 0..components {
            if row != column {
                correlation[(row, column)] *= 1.0 - shrink;
            }
        }
    }
    let eigen = correlation
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| CalibrateError::Alike)?;
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    Ok(Mat::from_fn(components, components, |row, d| {
        vectors[(row, d)] / libm::sqrt(values[d].max(LEAST_VARIANCE))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve channels, each a bump over a 60 mm pad, with the gain of every press.
    fn changes(places: &Mat<f64>, gain: impl Fn(usize) -> f64) -> Mat<f64> {
        Mat::from_fn(places.nrows(), 12, |press, channel| {
            let (cx, cy) = ((channel % 4) as f64 * 20.0, (channel / 4) as f64 * 30.0);
            let (dx, dy) = (places[(press, 0)] - cx, places[(press, 1)] - cy);
            gain(press) * 300.0 * libm::exp(-(dx * dx + dy * dy) / 700.0)
        })
    }

    #[test]
    fn presses_of_other_strength_are_located() {
        let places = Mat::from_fn(60, 2, |i, axis| {
            60.0 * (0.5 + i as f64 * [0.754_877_666, 0.569_840_29][axis]).fract()
        });
        let spec = ComponentSpec {
            power: 0.6,
            unit: true,
            components: 8,
            limit: Some(3.0),
        };
        let seen = changes(&places, |press| 1.0 + 0.2 * (press % 3) as f64);
        let maps = ComponentMaps::fit(spec, &seen, &places).expect("sound");
        let new = Mat::from_fn(4, 2, |i, axis| {
            [[20.0, 25.0], [41.0, 33.0], [12.0, 48.0], [50.0, 15.0]][i][axis]
        });
        let found = maps.predict(&changes(&new, |_| 1.3));
        for press in 0..4 {
            let error = libm::hypot(
                found[(press, 0)] - new[(press, 0)],
                found[(press, 1)] - new[(press, 1)],
            );
            assert!(error < 2.5, "press {press} is off by {error} mm");
        }
    }
}
