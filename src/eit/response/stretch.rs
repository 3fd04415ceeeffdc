//! What a finger that is longer than wide changes beside the sum of its parts.
//!
//! Current along a long finger is carried all the way, current across it has to enter and leave: so the finger saturates less along its
//! axis than across it, by some twenty percent if it is twice as long as wide. To first order this adds the response to a conductivity
//! that rises along the axis and falls across it (the traceless part of the polarisation tensor: Ammari and Kang 2007, section 4.2). Two
//! vectors span it for all axes: along x, and along the diagonal.
//!
//! The vectors vary slowly, since they belong to a whole finger: they are kept at every second place of the table.

use super::cubic::Cubic;
use super::places::Places;
use super::quantized;
use super::scatter::LinearResponses;
use super::touch_model::HALF_RISE;
use crate::types::PointMm;

/// Places of the table for each one here, along each side.
const EVERY: usize = 2;
/// Index of the radius that the vectors are made with.
const RADIUS: usize = 3;
/// The two axes.
pub(super) const AXES: usize = 2;
/// The vectors are multiples of this, for which they are kept as integers: with a finger's radius, strength and stretch, as fine as
/// the steps of the terms (`quantized.rs`).
const STEP: f32 = 1.0 / 1_048_576.0;
/// What the vectors depend on beside the pad.
pub(super) const CONSTANTS: [f64; 3] = [EVERY as f64, RADIUS as f64, STEP as f64];

/// The vectors at every second place of a table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stretches {
    /// Places x axes x rank.
    values: Vec<f32>,
    rank: usize,
    columns: usize,
    rows: usize,
    /// Distance between places, mm, and steps before the pad's box.
    pitch_mm: f64,
    margin: f64,
}

/// The response of a stretch along one axis, in the table's coordinates, and its derivatives by x and y, 1/mm.
#[derive(Clone, Debug, Default)]
pub struct StretchResponse {
    /// Along x, along the diagonal; each a value and its derivatives by x and y.
    pub axes: [[Vec<f32>; 3]; AXES],
}

impl Stretches {
    /// The number of values for a table of such places and rank.
    pub(super) fn count(places: &Places, rank: usize) -> usize {
        let [columns, rows] = grid(places);
        columns * rows * AXES * rank
    }

    /// From the values at all places, which are rounded.
    ///
    /// # Panics
    /// If there are not [`Stretches::count`] values.
    pub(super) fn new(mut values: Vec<f32>, places: &Places, rank: usize) -> Self {
        assert_eq!(values.len(), Self::count(places, rank));
        for value in &mut values {
            *value = integer(*value) as f32 * STEP;
        }
        let [columns, rows] = grid(places);
        Self {
            values,
            rank,
            columns,
            rows,
            pitch_mm: EVERY as f64 * places.pitch_mm,
            margin: places.margin as f64 / EVERY as f64,
        }
    }

    /// How many rows of places there are; not more than the table has.
    pub(super) fn rows(places: &Places) -> usize {
        grid(places)[1]
    }

    /// Solves one row of places: places x axes, each the relative changes of all readings.
    pub(super) fn solve_row(
        linear: &LinearResponses,
        places: &Places,
        row: usize,
    ) -> Vec<Vec<f64>> {
        let radius_mm = places.radii_mm()[RADIUS];
        let scale = HALF_RISE / (radius_mm * radius_mm);
        let at_mm = |step: usize| ((EVERY * step) as f64 - places.margin as f64) * places.pitch_mm;
        let [columns, _] = grid(places);
        (0..columns)
            .flat_map(|column| linear.per_stretch([at_mm(column), at_mm(row)], radius_mm))
            .map(|changes| changes.iter().map(|change| scale * change).collect())
            .collect()
    }

    /// The vectors as bytes.
    pub(super) fn pack(&self) -> Vec<u8> {
        let integers: Vec<i32> = self.values.iter().map(|value| integer(*value)).collect();
        quantized::pack_integers(&integers, AXES * self.rank)
    }

    /// The vectors of bytes that [`Stretches::pack`] made.
    ///
    /// # Panics
    /// If there are not four bytes for each of [`Stretches::count`] values.
    pub(super) fn unpack(bytes: &[u8], places: &Places, rank: usize) -> Self {
        let mut values = Vec::with_capacity(bytes.len() / 4);
        quantized::unpack_integers(bytes, AXES * rank, |integers| {
            values.extend(integers.iter().map(|integer| *integer as f32 * STEP));
        });
        Self::new(values, places, rank)
    }

    /// The vectors at a place, for radius squared x strength of 1 mm2.
    pub(super) fn respond(&self, centre_mm: PointMm, response: &mut StretchResponse) {
        for values in response.axes.as_flattened_mut() {
            values.clear();
            values.resize(self.rank, 0.0);
        }
        let at = centre_mm.map(|at_mm| at_mm / self.pitch_mm + self.margin);
        let across = Cubic::at(at[0], self.columns).per(self.pitch_mm);
        let up = Cubic::at(at[1], self.rows).per(self.pitch_mm);
        for index in 0..16 {
            let (j, i) = (index / 4, index % 4);
            let place = (up.first + j) * self.columns + across.first + i;
            let weights = [
                across.value[i] * up.value[j],
                across.slope[i] * up.value[j],
                across.value[i] * up.slope[j],
            ];
            let rows = self.values[place * AXES * self.rank..].chunks_exact(self.rank);
            for (axis, row) in response.axes.iter_mut().zip(rows) {
                for (sums, weight) in axis.iter_mut().zip(weights) {
                    for (sum, value) in sums.iter_mut().zip(row) {
                        *sum += weight * value;
                    }
                }
            }
        }
    }
}

/// A value as a multiple of the step.
fn integer(value: f32) -> i32 {
    libm::roundf(value / STEP) as i32
}

/// Columns and rows: enough to reach the last place of the table.
fn grid(places: &Places) -> [usize; 2] {
    [places.columns, places.rows].map(|count| (count - 1).div_ceil(EVERY) + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Otherwise rows are never solved: each is solved with the table's row of its number.
        #[test]
        fn a_table_has_at_least_as_many_rows(width in 5.0..2000.0f64, height in 5.0..2000.0f64) {
            let places = Places::new([width, height]);
            prop_assert!(Stretches::rows(&places) <= places.rows);
        }
    }
}
