//! Small dense systems, solved in an order of summation fixed by this source.

use std::ops::{AddAssign, Mul};

/// Solves a symmetric positive definite system by Cholesky factorisation. `matrix` holds the lower triangle in row-major
/// order; the solution replaces `vector`. Returns false if the matrix is not positive definite. No library promises the
/// order of summation.
pub(crate) fn solve_in_place(matrix: &mut [f64], vector: &mut [f64]) -> bool {
    let n = vector.len();
    for row in 0..n {
        let (above, below) = matrix.split_at_mut(row * n);
        let current = &mut below[..n];
        for column in 0..row {
            let other = &above[column * n..column * n + column + 1];
            let sum = current[column] - dot(&current[..column], &other[..column]);
            current[column] = sum / other[column];
        }
        let rest = current[row] - dot(&current[..row], &current[..row]);
        if rest <= 1e-12 || !rest.is_finite() {
            return false;
        }
        current[row] = libm::sqrt(rest);
    }
    for row in 0..n {
        let factor = &matrix[row * n..row * n + row + 1];
        vector[row] = (vector[row] - dot(&factor[..row], &vector[..row])) / factor[row];
    }
    for row in (0..n).rev() {
        let value = vector[row] / matrix[row * n + row];
        vector[row] = value;
        for column in 0..row {
            vector[column] -= value * matrix[row * n + column];
        }
    }
    true
}

/// y += a x.
pub(crate) fn add_scaled<T: Copy + AddAssign + Mul<Output = T>>(y: &mut [T], x: &[T], a: T) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * *x;
    }
}

/// Dot product by eight running sums, added in a fixed tree.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let mut sums = [0.0; LANES];
    let (a_chunks, a_rest) = a.as_chunks::<LANES>();
    let (b_chunks, b_rest) = b.as_chunks::<LANES>();
    for (x, y) in a_chunks.iter().zip(b_chunks) {
        for lane in 0..LANES {
            sums[lane] += x[lane] * y[lane];
        }
    }
    for (lane, (x, y)) in a_rest.iter().zip(b_rest).enumerate() {
        sums[lane] += x * y;
    }
    ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]))
}
