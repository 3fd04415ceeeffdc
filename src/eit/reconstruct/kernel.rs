//! Matrix times vector in f32, in one fixed order of summation.
//!
//! Invariant: the same bits on every x86-64 machine. Sixteen running sums take the products in turn and are
//! added in a fixed tree at the end; Rust neither reorders nor fuses floating-point operations, so whatever
//! vector width the compiler chooses gives these bits.

use faer::Mat;

/// Running sums of a dot product.
const LANES: usize = 16;

/// A matrix by rows, each padded with zeros to a multiple of [`LANES`].
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RowMatrix {
    columns: usize,
    stride: usize,
    values: Vec<f32>,
}

impl RowMatrix {
    /// The transpose of an f64 matrix, rounded to f32.
    pub(super) fn transposed(matrix: &Mat<f64>) -> Self {
        let columns = matrix.nrows();
        let stride = columns.next_multiple_of(LANES);
        let mut values = vec![0.0; stride * matrix.ncols()];
        for (row, target) in values.chunks_exact_mut(stride).enumerate() {
            for (value, source) in target.iter_mut().zip(matrix.col(row).iter()) {
                *value = *source as f32;
            }
        }
        Self {
            columns,
            stride,
            values,
        }
    }

    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    /// One row times a vector.
    ///
    /// # Panics
    /// If the vector's length is not the number of columns.
    pub(super) fn row_dot(&self, row: usize, vector: &[f32]) -> f32 {
        assert_eq!(vector.len(), self.columns, "one value a channel");
        let row = &self.values[row * self.stride..(row + 1) * self.stride];
        let mut sums = [0.0f32; LANES];
        let (chunks, rest) = vector.as_chunks::<LANES>();
        let (rows, _) = row.as_chunks::<LANES>();
        for (values, factors) in chunks.iter().zip(rows) {
            for lane in 0..LANES {
                sums[lane] += values[lane] * factors[lane];
            }
        }
        let tail = &row[chunks.len() * LANES..];
        for (lane, (value, factor)) in rest.iter().zip(tail).enumerate() {
            sums[lane] += value * factor;
        }
        let mut width = LANES / 2;
        while width > 0 {
            for lane in 0..width {
                sums[lane] += sums[lane + width];
            }
            width /= 2;
        }
        sums[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_row_is_the_sum_of_its_products(values in proptest::collection::vec(-1.0..1.0f64, 1..70)) {
            let matrix = Mat::from_fn(values.len(), 2, |i, j| if j == 1 { values[i] } else { 9.0 });
            let vector: Vec<f32> = values.iter().rev().map(|v| *v as f32).collect();
            let exact: f64 = values.iter().zip(&vector).map(|(a, b)| a * f64::from(*b)).sum();
            let got = f64::from(RowMatrix::transposed(&matrix).row_dot(1, &vector));
            prop_assert!((got - exact).abs() < 1e-4, "{got} against {exact}");
        }
    }

    #[test]
    fn the_order_of_summation_never_changes() {
        // Values whose f32 sum depends on the order; the bits were written down once.
        let matrix = Mat::from_fn(37, 1, |i, _| 1.0 / (i as f64 + 1.0));
        let vector: Vec<f32> = (0..37).map(|i| i as f32 * 0.037 - 0.5).collect();
        let bits = RowMatrix::transposed(&matrix).row_dot(0, &vector).to_bits();
        assert_eq!(bits, 0xbf63_22ee, "{bits:#x}");
    }
}
