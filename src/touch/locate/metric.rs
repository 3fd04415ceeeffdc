//! Channel weights: transforms readings and responses to coordinates in which noise has standard deviation one.
//!
//! Responses lie in the few dimensions of the table's basis U. With W one over the variance of each channel, the weighted
//! sum of squares between readings d and a response U c is |z - w(c)|^2 plus what no response explains, where
//! G = U' W U = L L', z = L^-1 U' W d and w(c) = L' c. If all channels are about equally noisy, L is a number.

use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side};

use crate::eit::response::Response;
use crate::eit::{ResponseTable, SharedNoise, median};
use crate::pad::LearnedMaps;
use crate::touch::ChannelNoise;
use crate::types::ByteReader;

/// Channels whose deviations are within this factor of the median are weighted equally, which is cheap.
const EVEN_WITHIN: f64 = 1.5;
/// Regularises directions that only dead channels show, as a share of the strongest direction.
const RIDGE: f64 = 1e-9;

/// The weights of the channels and the transforms that follow from them.
#[derive(Clone, Debug)]
pub(super) struct Metric {
    rank: usize,
    channels: usize,
    /// Rank x channels: readings to whitened coordinates.
    whitening: Vec<f32>,
    /// One over the deviation of each channel; 0 for an excluded one.
    inverse_deviation: Vec<f32>,
    /// Number of channels that are not excluded.
    counted: usize,
    /// Shared directions x channels: P of the precision D^-1 - P' P.
    shared: Vec<f32>,
    responses: Whitener,
}

#[derive(Clone, Debug)]
enum Whitener {
    /// All channels equal: one over their deviation.
    Even(f32),
    /// L': rank x rank, upper triangular, in column-major order.
    Triangle(Vec<f32>),
}

/// A frame in whitened coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Whitened {
    /// The coordinates.
    pub(super) coordinates: Vec<f32>,
    /// Weighted sum of squares of all readings.
    pub(super) energy: f64,
}

impl Whitened {
    /// Weighted sum of squares of what no touch at any place explains.
    #[must_use]
    pub(super) fn outside(&self) -> f64 {
        (self.energy - energy(&self.coordinates)).max(0.0)
    }
}

impl Metric {
    /// Weights for channels of the given relative deviations; a channel whose deviation is not finite or not above zero is
    /// excluded. What learned maps leave unexplained of a press counts as noise, too.
    ///
    /// # Panics
    /// If there is not one deviation per channel.
    #[must_use]
    pub(super) fn new(
        table: &ResponseTable,
        noise: &ChannelNoise,
        drives: &[u16],
        learned: Option<&LearnedMaps>,
    ) -> Self {
        assert_eq!(noise.deviations.len(), table.channels());
        let deviations: Vec<f64> = match learned {
            None => noise.deviations.clone(),
            Some(maps) => {
                let pairs = noise.deviations.iter().zip(&maps.deviations);
                pairs
                    .map(|(noise, left)| libm::hypot(*noise, *left))
                    .collect()
            }
        };
        let (rank, channels) = (table.rank(), table.channels());
        let counts = |deviation: f64| deviation.is_finite() && deviation > 0.0;
        let inverse: Vec<f64> = deviations
            .iter()
            .map(|deviation| {
                if counts(*deviation) {
                    1.0 / deviation
                } else {
                    0.0
                }
            })
            .collect();
        let mut used: Vec<f64> = inverse.iter().copied().filter(|i| *i > 0.0).collect();
        let counted = used.len();
        let median = median(&mut used).unwrap_or(0.0);
        let is_even = counted == channels
            && used
                .iter()
                .all(|i| (median / EVEN_WITHIN..=median * EVEN_WITHIN).contains(i));
        let mut metric = Self {
            rank,
            channels,
            whitening: Vec::with_capacity(rank * channels),
            inverse_deviation: inverse.iter().map(|value| *value as f32).collect(),
            counted,
            shared: Vec::new(),
            responses: Whitener::Even(median as f32),
        };
        let directions = shared_directions(noise.shared, drives, learned);
        if !directions.is_empty() {
            let shared = shared_rows(&inverse, &directions);
            metric.set_uneven_weights(table, &inverse, median, &shared);
            metric.shared = shared.iter().map(|value| *value as f32).collect();
        } else if is_even {
            metric.inverse_deviation.fill(median as f32);
            for dimension in 0..rank {
                let row = table.basis_row(dimension);
                metric
                    .whitening
                    .extend(row.iter().map(|value| value * median as f32));
            }
        } else {
            metric.set_uneven_weights(table, &inverse, median, &[]);
        }
        metric
    }

    fn set_uneven_weights(
        &mut self,
        table: &ResponseTable,
        inverse: &[f64],
        median: f64,
        shared: &[f64],
    ) {
        let (rank, channels) = (self.rank, self.channels);
        // W^1/2 U, channels by rank.
        let weighted = Mat::from_fn(channels, rank, |channel, dimension| {
            f64::from(table.basis_row(dimension)[channel]) * inverse[channel]
        });
        let mut gram = weighted.transpose() * &weighted;
        // P U, shared directions by rank.
        let directions = shared.len() / channels;
        let projected = Mat::from_fn(directions, rank, |direction, dimension| {
            let row = &shared[direction * channels..(direction + 1) * channels];
            let basis = table.basis_row(dimension);
            row.iter()
                .zip(basis)
                .map(|(p, u)| p * f64::from(*u))
                .sum::<f64>()
        });
        if directions > 0 {
            gram -= projected.transpose() * &projected;
        }
        let ridge = RIDGE * (median * median).max(f64::MIN_POSITIVE);
        for dimension in 0..rank {
            gram[(dimension, dimension)] += ridge;
        }
        // The ridge makes it positive definite; if it is not, no touch can be located.
        let lower = match gram.llt(Side::Lower) {
            Ok(factor) => factor.L().to_owned(),
            Err(_) => Mat::zeros(rank, rank),
        };
        let solver = lower.partial_piv_lu();
        let inverse_lower = solver.inverse();
        let whitening = &inverse_lower * weighted.transpose();
        let unshared = &inverse_lower * projected.transpose();
        self.whitening.clear();
        for dimension in 0..rank {
            self.whitening.extend((0..channels).map(|channel| {
                let common: f64 = (0..directions)
                    .map(|direction| {
                        unshared[(dimension, direction)] * shared[direction * channels + channel]
                    })
                    .sum();
                (whitening[(dimension, channel)] * inverse[channel] - common) as f32
            }));
        }
        let triangle = (0..rank)
            .flat_map(|column| (0..rank).map(move |row| (row, column)))
            .map(|(row, column)| lower[(column, row)] as f32)
            .collect();
        self.responses = Whitener::Triangle(triangle);
    }

    /// Appends the number of channels that count (u32), whitening and inverse deviations (f32), and the whitening of
    /// responses: a 0 and a factor, or a 1 and the triangle (f32), or a 2, the triangle, and
    /// the number of shared directions (u32) with their rows (f32).
    pub(super) fn to_bytes(&self, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&(self.counted as u32).to_le_bytes());
        let (kind, factors) = match &self.responses {
            Whitener::Even(factor) => (0, std::slice::from_ref(factor)),
            Whitener::Triangle(triangle) if self.shared.is_empty() => (1, triangle.as_slice()),
            Whitener::Triangle(triangle) => (2, triangle.as_slice()),
        };
        for value in self.whitening.iter().chain(&self.inverse_deviation) {
            bytes.extend_from_slice(&value.to_le_bytes());
        }
        bytes.push(kind);
        for value in factors {
            bytes.extend_from_slice(&value.to_le_bytes());
        }
        if !self.shared.is_empty() {
            let directions = self.shared.len() / self.channels;
            bytes.extend_from_slice(&(directions as u32).to_le_bytes());
            for value in &self.shared {
                bytes.extend_from_slice(&value.to_le_bytes());
            }
        }
    }

    /// Reads weights for a table; `None` if there are too few bytes, or a value is out of range.
    pub(super) fn from_bytes(bytes: &mut ByteReader<'_>, table: &ResponseTable) -> Option<Self> {
        let (rank, channels) = (table.rank(), table.channels());
        let counted = bytes.u32()? as usize;
        let whitening = bytes.f32s(rank.checked_mul(channels)?)?;
        let inverse_deviation = bytes.f32s(channels)?;
        let kind = bytes.u8()?;
        let responses = match kind {
            0 => Whitener::Even(bytes.f32()?),
            1 | 2 => Whitener::Triangle(bytes.f32s(rank.checked_mul(rank)?)?),
            _ => return None,
        };
        let shared = match kind {
            2 => {
                let directions = bytes.u32()? as usize;
                bytes.f32s(directions.checked_mul(channels)?)?
            }
            _ => Vec::new(),
        };
        let all_finite = |values: &[f32]| values.iter().all(|value| value.is_finite());
        let are_factors_finite = match &responses {
            Whitener::Even(factor) => factor.is_finite(),
            Whitener::Triangle(triangle) => all_finite(triangle),
        };
        let is_valid = counted <= channels
            && (all_finite(&whitening) && all_finite(&inverse_deviation) && are_factors_finite)
            && all_finite(&shared)
            && inverse_deviation.iter().all(|inverse| *inverse >= 0.0);
        is_valid.then_some(Self {
            rank,
            channels,
            whitening,
            inverse_deviation,
            counted,
            shared,
            responses,
        })
    }

    /// Number of channels that are not excluded.
    #[must_use]
    pub(super) fn counted(&self) -> usize {
        self.counted
    }

    /// Whether each channel counts: not an excluded one.
    pub(super) fn are_counted(&self) -> impl Iterator<Item = bool> + '_ {
        self.inverse_deviation.iter().map(|inverse| *inverse > 0.0)
    }

    /// Whitens relative changes.
    pub(super) fn whiten(&self, changes: &[f32], whitened: &mut Whitened) {
        whitened.coordinates.clear();
        whitened.coordinates.extend(
            self.whitening
                .chunks_exact(self.channels)
                .map(|row| dot(row, changes)),
        );
        whitened.energy = changes
            .iter()
            .zip(&self.inverse_deviation)
            .map(|(change, inverse)| {
                let weighted = if *inverse > 0.0 {
                    f64::from(change * inverse)
                } else {
                    0.0
                };
                weighted * weighted
            })
            .sum();
        for row in self.shared.chunks_exact(self.channels) {
            let along = f64::from(dot(row, changes));
            whitened.energy -= along * along;
        }
    }

    /// Whitens a response and its derivatives, in place.
    pub(super) fn whiten_response(&self, response: &mut Response) {
        self.whiten_coordinates(&mut response.value);
        for derivative in &mut response.derivatives {
            self.whiten_coordinates(derivative);
        }
    }

    /// Whitens coordinates of the table, in place.
    pub(super) fn whiten_coordinates(&self, coordinates: &mut [f32]) {
        match &self.responses {
            Whitener::Even(factor) => {
                for value in coordinates {
                    *value *= factor;
                }
            }
            Whitener::Triangle(triangle) => {
                // Upper triangular: column k adds to rows up to k only, so this works in place.
                for (column, entries) in triangle.chunks_exact(self.rank).enumerate() {
                    let value = coordinates[column];
                    coordinates[column] = 0.0;
                    for (sum, entry) in coordinates[..=column].iter_mut().zip(entries) {
                        *sum += value * entry;
                    }
                }
            }
        }
    }
}

/// A direction of changes that channels share, and its variance.
type SharedDirection = (Vec<f64>, f64);

/// The directions of shared gains, and of what learned maps leave unexplained.
fn shared_directions(
    noise: SharedNoise,
    drives: &[u16],
    learned: Option<&LearnedMaps>,
) -> Vec<SharedDirection> {
    let count = drives.iter().max().map_or(0, |last| usize::from(*last) + 1);
    let mut directions = Vec::new();
    if noise.gain > 0.0 {
        directions.push((vec![1.0; drives.len()], noise.gain));
    }
    if noise.drive > 0.0 {
        for drive in 0..count {
            let marks = drives
                .iter()
                .map(|own| f64::from(u8::from(usize::from(*own) == drive)));
            directions.push((marks.collect(), noise.drive));
        }
    }
    let left = learned.into_iter().flat_map(|maps| &maps.shared);
    directions.extend(left.map(|direction| (direction.clone(), 1.0)));
    directions
}

/// P by rows, such that the precision of channels with noise of their own and in shared directions is D^-1 - P' P (Woodbury:
/// P = L^-1 B' D^-1 with L L' = S^-1 + B' D^-1 B, where B holds the shared directions and S their variances).
fn shared_rows(inverse: &[f64], directions: &[SharedDirection]) -> Vec<f64> {
    let channels = inverse.len();
    let size = directions.len();
    let weighted = |direction: usize, channel: usize| {
        directions[direction].0[channel] * inverse[channel] * inverse[channel]
    };
    let gram = Mat::from_fn(size, size, |row, column| {
        let sum: f64 = (0..channels)
            .map(|channel| weighted(row, channel) * directions[column].0[channel])
            .sum();
        if row == column {
            sum + 1.0 / directions[row].1
        } else {
            sum
        }
    });
    // Positive definite: a sum of squares and a positive diagonal.
    let Ok(factor) = gram.llt(Side::Lower) else {
        return Vec::new();
    };
    let inverse_lower = factor.L().to_owned().partial_piv_lu().inverse();
    (0..size)
        .flat_map(|row| (0..channels).map(move |channel| (row, channel)))
        .map(|(row, channel)| {
            (0..=row)
                .map(|k| inverse_lower[(row, k)] * weighted(k, channel))
                .sum()
        })
        .collect()
}

/// Sum of squares.
#[must_use]
pub(super) fn energy(values: &[f32]) -> f64 {
    values.iter().map(|v| f64::from(*v) * f64::from(*v)).sum()
}

/// Dot product, in a fixed order of sixteen running sums.
#[must_use]
pub(super) fn dot(a: &[f32], b: &[f32]) -> f32 {
    const LANES: usize = 16;
    let (a_chunks, a_rest) = a.as_chunks::<LANES>();
    let (b_chunks, b_rest) = b.as_chunks::<LANES>();
    let mut sums = [0.0f32; LANES];
    for (x, y) in a_chunks.iter().zip(b_chunks) {
        for lane in 0..LANES {
            sums[lane] += x[lane] * y[lane];
        }
    }
    let mut total = 0.0;
    for sum in sums {
        total += sum;
    }
    for (x, y) in a_rest.iter().zip(b_rest) {
        total += x * y;
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The residual of the whitened coordinates plus what lies outside of them is the weighted sum of squares.
        #[test]
        fn costs_are_weighted_sums_of_squares(
            changes in proptest::collection::vec(-1.0..1.0f32, 12),
            coordinates in proptest::collection::vec(-1.0..1.0f32, 8),
            deviations in proptest::collection::vec(0.2..3.0f64, 12),
            excluded in 0..12usize,
            is_even in any::<bool>(),
        ) {
            let table = ResponseTable::small();
            let deviations: Vec<f64> = if is_even {
                vec![0.5; 12]
            } else {
                let all = deviations.into_iter().enumerate();
                all.map(|(c, d)| if c == excluded { f64::INFINITY } else { d }).collect()
            };
            let metric = Metric::new(&table, &deviations.clone().into(), &[0; 12], None);
            prop_assert_eq!(metric.counted(), if is_even { 12 } else { 11 });
            let mut whitened = Whitened::default();
            metric.whiten(&changes, &mut whitened);
            let mut response = coordinates.clone();
            metric.whiten_coordinates(&mut response);
            let rest: Vec<f32> = whitened.coordinates.iter().zip(&response).map(|(z, w)| z - w).collect();
            let whole = energy(&rest) + whitened.outside();
            let mut explained = vec![0.0; 12];
            table.expand(&coordinates, &mut explained);
            let direct: f64 = (0..12)
                .filter(|c| deviations[*c].is_finite())
                .map(|c| f64::from(changes[c] - explained[c]) / deviations[c])
                .map(|weighted| weighted * weighted)
                .sum();
            prop_assert!((whole - direct).abs() < 1e-3 * (1.0 + direct), "{whole} for {direct}");
        }
    }
}
