//! Matrix times vector in f32, in a fixed order of summation.
//!
//! Invariant: the same bits on every x86-64 machine. Products go to sixteen running sums in turn, which a fixed tree adds
//! at the end; Rust neither reorders nor fuses floating-point operations, so any vector width gives the same bits. The
//! widest vectors of the processor are chosen at run time.

use faer::Mat;
use pulp::{Arch, Simd, WithSimd};

use crate::types::ByteReader;

/// Running sums of a dot product.
const LANES: usize = 16;

/// A matrix in row-major order, each row padded with zeros to whole chunks.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct RowMatrix {
    columns: usize,
    chunks_per_row: usize,
    chunks: Vec<[f32; LANES]>,
}

/// A vector padded with zeros to whole chunks.
#[derive(Clone, Debug, Default)]
pub(super) struct Padded {
    chunks: Vec<[f32; LANES]>,
}

impl Padded {
    /// Copies a vector.
    pub(super) fn set(&mut self, vector: &[f32]) {
        self.chunks.clear();
        let (whole, rest) = vector.as_chunks::<LANES>();
        self.chunks.extend_from_slice(whole);
        if !rest.is_empty() {
            let mut last = [0.0; LANES];
            last[..rest.len()].copy_from_slice(rest);
            self.chunks.push(last);
        }
    }
}

impl RowMatrix {
    /// The transpose of an f64 matrix, rounded to f32.
    pub(super) fn transposed(matrix: &Mat<f64>) -> Self {
        let columns = matrix.nrows();
        let chunks_per_row = columns.div_ceil(LANES);
        let mut chunks = vec![[0.0; LANES]; chunks_per_row * matrix.ncols()];
        for (row, target) in chunks.chunks_exact_mut(chunks_per_row).enumerate() {
            let values = target.as_flattened_mut();
            for (value, source) in values.iter_mut().zip(matrix.col(row).iter()) {
                *value = *source as f32;
            }
        }
        Self {
            columns,
            chunks_per_row,
            chunks,
        }
    }

    /// Appends the number of columns (u32) and the rows (f32) without padding.
    pub(super) fn to_bytes(&self, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&(self.columns as u32).to_le_bytes());
        for row in self.chunks.chunks_exact(self.chunks_per_row.max(1)) {
            for value in &row.as_flattened()[..self.columns] {
                bytes.extend_from_slice(&value.to_le_bytes());
            }
        }
    }

    /// Reads `rows` rows; `None` if there are too few bytes, or a value is not finite.
    pub(super) fn from_bytes(bytes: &mut ByteReader<'_>, rows: usize) -> Option<Self> {
        let columns = bytes.count()?;
        let chunks_per_row = columns.div_ceil(LANES);
        let mut chunks = Vec::new();
        let mut padded = Padded::default();
        for _ in 0..rows {
            let row = bytes.f32s(columns)?;
            if !row.iter().all(|value| value.is_finite()) {
                return None;
            }
            padded.set(&row);
            chunks.extend_from_slice(&padded.chunks);
        }
        (columns > 0).then_some(Self {
            columns,
            chunks_per_row,
            chunks,
        })
    }

    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    /// Writes the product of every row with a vector to `products`.
    ///
    /// # Panics
    /// If the vector has another number of chunks than a row.
    pub(super) fn times(&self, vector: &Padded, products: &mut Vec<f32>) {
        assert_eq!(
            vector.chunks.len(),
            self.chunks_per_row,
            "one value per channel"
        );
        products.clear();
        products.resize(self.chunks.len() / self.chunks_per_row, 0.0);
        Arch::new().dispatch(Products {
            matrix: self,
            vector,
            products,
        });
    }
}

/// The sums of [`RowMatrix::times`], dispatched by processor: only code inlined here is compiled for each.
struct Products<'a> {
    matrix: &'a RowMatrix,
    vector: &'a Padded,
    products: &'a mut [f32],
}

impl WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let rows = self.matrix.chunks.chunks_exact(self.matrix.chunks_per_row);
        for (product, row) in self.products.iter_mut().zip(rows) {
            *product = tree_sum(running_sums(simd, row, &self.vector.chunks));
        }
    }
}

/// The running sums. Explicit, because the compiler would otherwise use vectors of two lanes, to suit the final tree.
#[inline(always)]
fn running_sums<S: Simd>(simd: S, row: &[[f32; LANES]], vector: &[[f32; LANES]]) -> [f32; LANES] {
    let mut sums = [0.0; LANES];
    if S::F32_LANES == 1 {
        for (factors, values) in row.iter().zip(vector) {
            for lane in 0..LANES {
                sums[lane] += factors[lane] * values[lane];
            }
        }
        return sums;
    }
    // At most sixteen vectors, if each holds one lane.
    let mut wide = [simd.splat_f32s(0.0); LANES];
    for (factors, values) in row.iter().zip(vector) {
        let ((factors, _), (values, _)) = (S::as_simd_f32s(factors), S::as_simd_f32s(values));
        for ((sum, factor), value) in wide.iter_mut().zip(factors).zip(values) {
            *sum = simd.add_f32s(*sum, simd.mul_f32s(*factor, *value));
        }
    }
    for (sum, wide) in S::as_mut_simd_f32s(&mut sums).0.iter_mut().zip(wide) {
        *sum = wide;
    }
    sums
}

#[inline(always)]
fn tree_sum(sums: [f32; LANES]) -> f32 {
    let eight: [f32; 8] = std::array::from_fn(|i| sums[i] + sums[i + 8]);
    let four: [f32; 4] = std::array::from_fn(|i| eight[i] + eight[i + 4]);
    (four[0] + four[2]) + (four[1] + four[3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn product(matrix: &Mat<f64>, vector: &[f32]) -> Vec<f32> {
        let mut padded = Padded::default();
        padded.set(vector);
        let mut products = Vec::new();
        RowMatrix::transposed(matrix).times(&padded, &mut products);
        products
    }

    proptest! {
        #[test]
        fn a_product_is_the_sum_of_its_terms(values in proptest::collection::vec(-1.0..1.0f64, 1..70)) {
            let matrix = Mat::from_fn(values.len(), 2, |i, j| if j == 1 { values[i] } else { 9.0 });
            let vector: Vec<f32> = values.iter().rev().map(|v| *v as f32).collect();
            let exact: f64 = values.iter().zip(&vector).map(|(a, b)| a * f64::from(*b)).sum();
            let got = f64::from(product(&matrix, &vector)[1]);
            prop_assert!((got - exact).abs() < 1e-4, "{got} against {exact}");
        }
    }

    proptest! {
        #[test]
        fn every_processor_gives_the_same_bits(values in proptest::collection::vec(-1.0..1.0f64, 1..300)) {
            let matrix = Mat::from_fn(values.len(), 5, |i, j| values[i] * (j as f64 - 1.7));
            let vector: Vec<f32> = values.iter().rev().map(|v| *v as f32).collect();
            let (rows, mut padded) = (RowMatrix::transposed(&matrix), Padded::default());
            padded.set(&vector);
            // Compiled for the baseline processor.
            let mut plain = vec![0.0; 5];
            Products { matrix: &rows, vector: &padded, products: &mut plain }.with_simd(pulp::Scalar);
            let bits = |products: &[f32]| products.iter().map(|p| p.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(&plain), bits(&product(&matrix, &vector)));
        }
    }

    #[test]
    fn the_order_of_summation_never_changes() {
        // Values whose f32 sum depends on the order of summation.
        let matrix = Mat::from_fn(37, 1, |i, _| 1.0 / (i as f64 + 1.0));
        let vector: Vec<f32> = (0..37).map(|i| i as f32 * 0.037 - 0.5).collect();
        let bits = product(&matrix, &vector)[0].to_bits();
        assert_eq!(bits, 0xbf63_22ee, "{bits:#x}");
    }
}
