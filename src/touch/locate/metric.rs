//! How much each reading counts: readings and responses brought to coordinates in which noise has deviation one.
//!
//! Responses live in the few dimensions of the table's basis U. With W one over the variance of each channel, the sum of
//! weighted squares between readings d and a response U c is |z - w(c)|^2 plus what no response explains, where
//! G = U' W U = L L', z = L^-1 U' W d and w(c) = L' c. While all channels are about equally noisy, L is a number.

use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side};

use crate::eit::ResponseTable;
use crate::eit::response::Response;
use crate::types::ByteReader;

/// Channels whose deviations stay within this factor of the median count as equal: then a weight costs nothing.
const EVEN_WITHIN: f64 = 1.5;
/// Keeps directions that only dead channels tell from being divided by nothing, as a share of the strongest.
const RIDGE: f64 = 1e-9;

/// Weights of the channels, and what follows from them.
#[derive(Clone, Debug)]
pub(super) struct Metric {
    rank: usize,
    channels: usize,
    /// Rank by channels: readings to whitened coordinates.
    whitening: Vec<f32>,
    /// One over the deviation of each channel; 0 for one that is left out.
    inverse_deviation: Vec<f32>,
    /// Channels that count.
    counted: usize,
    responses: Whitener,
}

#[derive(Clone, Debug)]
enum Whitener {
    /// All channels alike: one over their deviation.
    Even(f32),
    /// Rank by rank, upper triangular, by columns: L'.
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
    /// Weighted sum of squares of what no touch explains, wherever it may be.
    #[must_use]
    pub(super) fn outside(&self) -> f64 {
        (self.energy - energy(&self.coordinates)).max(0.0)
    }
}

impl Metric {
    /// Weights for channels of the given relative deviations; one that is not finite or not above zero leaves its channel
    /// out.
    ///
    /// # Panics
    /// If there is not one deviation a channel.
    #[must_use]
    pub(super) fn new(table: &ResponseTable, deviations: &[f64]) -> Self {
        assert_eq!(deviations.len(), table.channels());
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
        let mut sorted: Vec<f64> = inverse.iter().copied().filter(|i| *i > 0.0).collect();
        sorted.sort_by(f64::total_cmp);
        let counted = sorted.len();
        let median = sorted.get(counted / 2).copied().unwrap_or(0.0);
        let is_even = counted == channels
            && sorted
                .iter()
                .all(|i| (median / EVEN_WITHIN..=median * EVEN_WITHIN).contains(i));
        let mut metric = Self {
            rank,
            channels,
            whitening: Vec::with_capacity(rank * channels),
            inverse_deviation: inverse.iter().map(|value| *value as f32).collect(),
            counted,
            responses: Whitener::Even(median as f32),
        };
        if is_even {
            metric.inverse_deviation.fill(median as f32);
            for dimension in 0..rank {
                let row = table.basis_row(dimension);
                metric
                    .whitening
                    .extend(row.iter().map(|value| value * median as f32));
            }
        } else {
            metric.weigh_unevenly(table, &inverse, median);
        }
        metric
    }

    fn weigh_unevenly(&mut self, table: &ResponseTable, inverse: &[f64], median: f64) {
        let (rank, channels) = (self.rank, self.channels);
        // W^1/2 U, channels by rank.
        let weighted = Mat::from_fn(channels, rank, |channel, dimension| {
            f64::from(table.basis_row(dimension)[channel]) * inverse[channel]
        });
        let mut gram = weighted.transpose() * &weighted;
        let ridge = RIDGE * (median * median).max(f64::MIN_POSITIVE);
        for dimension in 0..rank {
            gram[(dimension, dimension)] += ridge;
        }
        // Positive definite by its ridge; were it not, a frame would tell nothing at all.
        let lower = match gram.llt(Side::Lower) {
            Ok(factor) => factor.L().to_owned(),
            Err(_) => Mat::zeros(rank, rank),
        };
        let solver = lower.partial_piv_lu();
        let inverse_lower = solver.inverse();
        let whitening = &inverse_lower * weighted.transpose();
        self.whitening.clear();
        for dimension in 0..rank {
            self.whitening
                .extend((0..channels).map(|c| (whitening[(dimension, c)] * inverse[c]) as f32));
        }
        let triangle = (0..rank)
            .flat_map(|column| (0..rank).map(move |row| (row, column)))
            .map(|(row, column)| lower[(column, row)] as f32)
            .collect();
        self.responses = Whitener::Triangle(triangle);
    }

    /// Appends the number that count (u32), whitening and inverse deviations (f32), and the responses' whitening: a 0 and a factor, or a 1 and
    /// the triangle (f32). Which factors stand in it depends on the solver's processor, so a recording keeps them.
    pub(super) fn to_bytes(&self, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&(self.counted as u32).to_le_bytes());
        let (kind, factors) = match &self.responses {
            Whitener::Even(factor) => (0, std::slice::from_ref(factor)),
            Whitener::Triangle(triangle) => (1, triangle.as_slice()),
        };
        for value in self.whitening.iter().chain(&self.inverse_deviation) {
            bytes.extend_from_slice(&value.to_le_bytes());
        }
        bytes.push(kind);
        for value in factors {
            bytes.extend_from_slice(&value.to_le_bytes());
        }
    }

    /// Weights for a table, from what [`Self::to_bytes`] gave.
    pub(super) fn from_bytes(bytes: &mut ByteReader<'_>, table: &ResponseTable) -> Option<Self> {
        let (rank, channels) = (table.rank(), table.channels());
        let counted = bytes.u32()? as usize;
        let whitening = bytes.f32s(rank.checked_mul(channels)?)?;
        let inverse_deviation = bytes.f32s(channels)?;
        let responses = match bytes.u8()? {
            0 => Whitener::Even(bytes.f32()?),
            1 => Whitener::Triangle(bytes.f32s(rank.checked_mul(rank)?)?),
            _ => return None,
        };
        (counted <= channels).then_some(Self {
            rank,
            channels,
            whitening,
            inverse_deviation,
            counted,
            responses,
        })
    }

    /// Number of channels that count.
    #[must_use]
    pub(super) fn counted(&self) -> usize {
        self.counted
    }

    /// Brings relative changes to whitened coordinates.
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
    }

    /// Brings a response and its derivatives to whitened coordinates, in place.
    pub(super) fn whiten_response(&self, response: &mut Response) {
        self.whiten_coordinates(&mut response.value);
        for derivative in &mut response.derivatives {
            self.whiten_coordinates(derivative);
        }
    }

    /// Brings coordinates of the table to whitened ones, in place.
    pub(super) fn whiten_coordinates(&self, coordinates: &mut [f32]) {
        match &self.responses {
            Whitener::Even(factor) => {
                for value in coordinates {
                    *value *= factor;
                }
            }
            Whitener::Triangle(triangle) => {
                // Upper triangular: what stands at k goes to the rows up to k only, so it can be done in place.
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

/// Sum of squares.
#[must_use]
pub(super) fn energy(values: &[f32]) -> f64 {
    values.iter().map(|v| f64::from(*v) * f64::from(*v)).sum()
}

/// Sum of products, in a fixed order of sixteen running sums.
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
        /// What the whitened coordinates leave, and what lies outside of them, is the weighted sum of squares.
        #[test]
        fn costs_are_weighted_sums_of_squares(
            changes in proptest::collection::vec(-1.0..1.0f32, 12),
            coordinates in proptest::collection::vec(-1.0..1.0f32, 8),
            deviations in proptest::collection::vec(0.2..3.0f64, 12),
            left_out in 0..12usize,
            is_even in any::<bool>(),
        ) {
            let table = ResponseTable::small();
            let deviations: Vec<f64> = if is_even {
                vec![0.5; 12]
            } else {
                let all = deviations.into_iter().enumerate();
                all.map(|(c, d)| if c == left_out { f64::INFINITY } else { d }).collect()
            };
            let metric = Metric::new(&table, &deviations);
            prop_assert_eq!(metric.counted(), if is_even { 12 } else { 11 });
            let mut whitened = Whitened::default();
            metric.whiten(&changes, &mut whitened);
            let mut response = coordinates.clone();
            metric.whiten_coordinates(&mut response);
            let rest: Vec<f32> = whitened.coordinates.iter().zip(&response).map(|(z, w)| z - w).collect();
            let told = energy(&rest) + whitened.outside();
            let mut explained = vec![0.0; 12];
            table.expand(&coordinates, &mut explained);
            let direct: f64 = (0..12)
                .filter(|c| deviations[*c].is_finite())
                .map(|c| f64::from(changes[c] - explained[c]) / deviations[c])
                .map(|weighted| weighted * weighted)
                .sum();
            prop_assert!((told - direct).abs() < 1e-3 * (1.0 + direct), "{told} for {direct}");
        }
    }
}
