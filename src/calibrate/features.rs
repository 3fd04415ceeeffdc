//! Features of a press for regression: its changes, compressed, scaled, and stretched along the directions that matter.
//!
//! The changes of a press differ by orders of magnitude between channels near it and far from it. A signed root or logarithm
//! gives the far ones weight; unit norm removes the force. Which of them suits a pad is not known beforehand, so several are
//! fitted and blended.

use faer::{Mat, Side};

use super::error::CalibrateError;
use super::process::{self, Hyperparameters};

/// The logarithm becomes linear below this share of the median change.
const LINEAR_BELOW: f64 = 0.7;
/// A channel is left out of weighted features if the place explains less of its variance than this.
const LEAST_EXPLAINED: f64 = 0.15;
/// Lengths (in deviations of the places) and noises tried for a channel's map over the pad.
const MAP_LENGTHS: [f64; 4] = [0.35, 0.7, 1.1, 1.6];
const MAP_NOISES: [f64; 3] = [0.01, 0.1, 0.5];
/// Share of the mean eigenvalue that a learned metric keeps in every direction.
const METRIC_FLOOR: f64 = 1e-6;
/// Power of the eigenvalues of the gradients' outer product in the learned map. A full step (0.5) overfits small sets.
const METRIC_POWER: f64 = 0.25;

/// How changes are compressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Compression {
    /// sign(d) |d|^p.
    Root(f64),
    /// asinh(d / scale).
    Log,
}

/// How features are made of changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FeatureSpec {
    pub compression: Compression,
    /// Whether each press is scaled to unit norm first.
    pub unit: bool,
    /// Whether each channel is weighted by how well the place explains it.
    pub weighted: bool,
}

/// A specification with the scales learned from presses.
#[derive(Clone, Debug)]
pub(super) struct Features {
    spec: FeatureSpec,
    scale: f64,
    weights: Vec<f64>,
    mean: Vec<f64>,
    size: f64,
}

impl Features {
    /// Learns from `changes` (presses by channels) with one weight for each channel.
    pub(super) fn fit(spec: FeatureSpec, changes: &Mat<f64>, weights: &[f64]) -> Self {
        let mut features = Self {
            spec,
            scale: LINEAR_BELOW * median_magnitude(changes),
            weights: if spec.weighted {
                weights.to_vec()
            } else {
                vec![1.0; changes.ncols()]
            },
            mean: vec![0.0; changes.ncols()],
            size: 1.0,
        };
        let shaped = features.apply(changes);
        let count = shaped.nrows() as f64;
        features.mean = (0..shaped.ncols())
            .map(|c| shaped.col(c).iter().sum::<f64>() / count)
            .collect();
        let squares: f64 = (0..shaped.ncols())
            .map(|c| {
                let mean = features.mean[c];
                shaped
                    .col(c)
                    .iter()
                    .map(|v| (v - mean) * (v - mean))
                    .sum::<f64>()
            })
            .sum();
        features.size =
            libm::sqrt(squares / (count * shaped.ncols() as f64)).max(f64::MIN_POSITIVE);
        features
    }

    /// The features of presses: presses by channels.
    pub(super) fn apply(&self, changes: &Mat<f64>) -> Mat<f64> {
        let norms: Vec<f64> = (0..changes.nrows())
            .map(|row| {
                if self.spec.unit {
                    process::norm(changes, row).max(f64::MIN_POSITIVE)
                } else {
                    1.0
                }
            })
            .collect();
        Mat::from_fn(changes.nrows(), changes.ncols(), |row, channel| {
            let change = changes[(row, channel)] / norms[row];
            let shaped = match self.spec.compression {
                Compression::Root(power) => root(change, power),
                Compression::Log => libm::asinh(change / self.scale),
            };
            (self.weights[channel] * shaped - self.mean[channel]) / self.size
        })
    }
}

/// sign(d) |d|^p.
pub(super) fn root(change: f64, power: f64) -> f64 {
    libm::copysign(libm::pow(change.abs(), power), change)
}

/// For each channel, the square root of the share of its variance that the place explains (leave-one-out); 0 below
/// [`LEAST_EXPLAINED`], for loose and noisy channels.
pub(super) fn channel_weights(
    changes: &Mat<f64>,
    places: &Mat<f64>,
) -> Result<Vec<f64>, CalibrateError> {
    let rooted = Mat::from_fn(changes.nrows(), changes.ncols(), |r, c| {
        root(changes[(r, c)], 0.5)
    });
    let distances2 = process::squared_distances(places, places);
    let spread = spread(places);
    let mut explained = vec![0.0_f64; changes.ncols()];
    for values in [changes, &rooted] {
        let total = sums_of_squares(values);
        for length in MAP_LENGTHS {
            for noise in MAP_NOISES {
                let hyper = Hyperparameters {
                    length: length * spread,
                    noise,
                };
                let left_out = process::leave_one_out(&distances2, values, hyper)?;
                for (channel, best) in explained.iter_mut().enumerate() {
                    let residual2 = left_out.residuals.col(channel).squared_norm_l2();
                    if total[channel] > 0.0 {
                        *best = best.max(1.0 - residual2 / total[channel]);
                    }
                }
            }
        }
    }
    Ok(explained
        .into_iter()
        .map(|share| {
            if share < LEAST_EXPLAINED {
                0.0
            } else {
                libm::sqrt(share)
            }
        })
        .collect())
}

/// The linear map that stretches features along the directions in which the outputs change, from the mean outer product of
/// their gradients.
pub(super) fn stretch(outer_product: &Mat<f64>) -> Result<Mat<f64>, CalibrateError> {
    let eigen = outer_product
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| CalibrateError::Alike)?;
    let (vectors, values) = (eigen.U(), eigen.S().column_vector());
    let dimensions = outer_product.nrows();
    let total: f64 = (0..dimensions).map(|d| values[d].max(0.0)).sum();
    let unit = (total / dimensions as f64).max(f64::MIN_POSITIVE);
    Ok(Mat::from_fn(dimensions, dimensions, |row, d| {
        let share = values[d].max(0.0) / unit;
        vectors[(row, d)] * libm::pow(share + METRIC_FLOOR, METRIC_POWER)
    }))
}

/// Root mean squared distance of places from their centre, over sqrt 2: the deviation along one axis.
pub(super) fn spread(places: &Mat<f64>) -> f64 {
    let squares: f64 = sums_of_squares(places).iter().sum();
    libm::sqrt(squares / (2.0 * places.nrows() as f64)).max(f64::MIN_POSITIVE)
}

/// Sum of squared deviations of each column.
fn sums_of_squares(values: &Mat<f64>) -> Vec<f64> {
    (0..values.ncols())
        .map(|c| {
            let mean = values.col(c).iter().sum::<f64>() / values.nrows() as f64;
            values.col(c).iter().map(|v| (v - mean) * (v - mean)).sum()
        })
        .collect()
}

fn median_magnitude(changes: &Mat<f64>) -> f64 {
    let mut values: Vec<f64> = (0..changes.ncols())
        .flat_map(|c| changes.col(c).iter().map(|v| v.abs()))
        .collect();
    values.sort_by(f64::total_cmp);
    // Where most channels do not change, the largest change gives the scale.
    let median = values[values.len() / 2];
    if median > 0.0 {
        median
    } else {
        values[values.len() - 1].max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SPECS: [FeatureSpec; 3] = [
        FeatureSpec {
            compression: Compression::Root(0.5),
            unit: true,
            weighted: false,
        },
        FeatureSpec {
            compression: Compression::Root(0.7),
            unit: true,
            weighted: true,
        },
        FeatureSpec {
            compression: Compression::Log,
            unit: false,
            weighted: false,
        },
    ];

    proptest! {
        #[test]
        fn the_unit_of_the_changes_does_not_matter(
            values in proptest::collection::vec(-100.0..100.0f64, 30),
            unit in 1e-3..1e3f64,
        ) {
            let changes = Mat::from_fn(6, 5, |r, c| values[5 * r + c]);
            let scaled = Mat::from_fn(6, 5, |r, c| unit * values[5 * r + c]);
            for spec in SPECS {
                let weights = [1.0; 5];
                let a = Features::fit(spec, &changes, &weights).apply(&changes);
                let b = Features::fit(spec, &scaled, &weights).apply(&scaled);
                for r in 0..6 {
                    for c in 0..5 {
                        prop_assert!((a[(r, c)] - b[(r, c)]).abs() < 1e-9);
                    }
                }
            }
        }
    }

    #[test]
    fn a_channel_of_noise_has_no_weight() {
        let mut noise = 0.1_f64;
        let places = Mat::from_fn(60, 2, |i, axis| ((i * (axis * 5 + 3)) % 17) as f64);
        let changes = Mat::from_fn(60, 2, |i, channel| {
            noise = (noise * 997.0 + 0.123).fract();
            if channel == 0 {
                places[(i, 0)] + 0.5 * places[(i, 1)]
            } else {
                noise - 0.5
            }
        });
        let weights = channel_weights(&changes, &places).expect("sound");
        assert!(weights[0] > 0.9, "{weights:?}");
        assert_eq!(weights[1], 0.0, "{weights:?}");
    }
}
