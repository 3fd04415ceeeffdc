//! Few pixels changed: argmin 1/2 |A x - dv|2 + lambda |x|1, with x >= 0 if asked for.
//!
//! A is the Jacobian with its columns scaled to unit norm, so that lambda weighs every pixel alike; lambda is a share
//! of max |A' dv|, above which the answer is zero, and never below what noise alone would make.
//!
//! A frame starts from the last one's answer and works on the pixels that matter only: coordinate descent on a working
//! set finds the support, a Newton step on it (a small Cholesky) jumps to the optimum of that support, and the gradient
//! of all pixels, which the Gram matrix gives cheaply, either names pixels to add or proves by the duality gap that the
//! answer is good. (Coordinate descent: Friedman, Hastie and Tibshirani 2010; gap: Kim et al. 2007, eq. 10-12; working
//! sets: Massias, Gramfort and Salmon 2018.)
//!
//! f64 throughout, every sum in the order of the source: the same frames give the same bits.

use faer::Mat;

use crate::eit::cholesky::{dot, solve_in_place};
use crate::types::ByteReader;

/// The paper's budget of iterations: here sweeps over the working set.
pub const ITERATIONS: usize = 200;
/// The answer is good when the duality gap is below this share of 1/2 |dv|2.
const GAP: f64 = 1e-7;
/// Sweeps of coordinate descent between two Newton steps.
const SWEEPS: usize = 3;
/// Pixels that join the working set at once.
const JOIN: usize = 24;
/// Noise alone reaches this many of its deviations in max |A' dv| of about a thousand pixels: sqrt(2 ln 1000).
const NOISE_REACH: f64 = 3.7;

/// What the solver needs of a pad: made once, shared.
#[derive(Clone, Debug, PartialEq)]
pub struct L1Model {
    channels: usize,
    /// Columns of A, one after the other.
    columns: Vec<f64>,
    /// A' A, by rows.
    gram: Vec<f64>,
    /// Norms of the Jacobian's columns.
    norms: Vec<f64>,
    lambda: f64,
    nonnegative: bool,
}

/// The running answer, from which the next frame starts.
#[derive(Clone, Debug, Default)]
pub struct L1State {
    /// The answer, in units of A's columns.
    x: Vec<f64>,
    /// A' dv.
    correlation: Vec<f64>,
    /// A' (dv - A x).
    gradient: Vec<f64>,
    working: Vec<usize>,
    in_working: Vec<bool>,
    scratch: Scratch,
}

#[derive(Clone, Debug, Default)]
struct Scratch {
    /// Gram matrix of the working set, by rows.
    gram: Vec<f64>,
    /// Gradient on the working set.
    gradient: Vec<f64>,
    factor: Vec<f64>,
    support: Vec<usize>,
    step: Vec<f64>,
}

/// How good an answer is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// 1/2 |A x - dv|2 + lambda |x|1.
    pub objective: f64,
    /// By how much the objective may exceed the least one.
    pub duality_gap: f64,
    /// The penalty's weight that was used.
    pub lambda_abs: f64,
    /// Sweeps over the working set.
    pub sweeps: usize,
}

impl L1Model {
    /// A model of a Jacobian (channels by pixels).
    #[must_use]
    pub fn new(jacobian: &Mat<f64>, lambda: f64, nonnegative: bool) -> Self {
        let (channels, pixels) = (jacobian.nrows(), jacobian.ncols());
        let norms: Vec<f64> = (0..pixels)
            .map(|p| jacobian.col(p).norm_l2().max(f64::MIN_POSITIVE))
            .collect();
        let unit = Mat::from_fn(channels, pixels, |m, p| jacobian[(m, p)] / norms[p]);
        let product = unit.transpose() * &unit;
        Self {
            channels,
            columns: (0..pixels)
                .flat_map(|p| unit.col(p).iter().copied().collect::<Vec<_>>())
                .collect(),
            gram: (0..pixels * pixels)
                .map(|i| product[(i / pixels, i % pixels)])
                .collect(),
            norms,
            lambda,
            nonnegative,
        }
    }

    /// Appends channels (u32), whether answers are kept at or above zero (a byte), lambda, columns, Gram matrix and norms (f64).
    pub(super) fn to_bytes(&self, bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&(self.channels as u32).to_le_bytes());
        bytes.push(u8::from(self.nonnegative));
        let lambda = std::iter::once(&self.lambda);
        for value in lambda
            .chain(&self.columns)
            .chain(&self.gram)
            .chain(&self.norms)
        {
            bytes.extend_from_slice(&value.to_le_bytes());
        }
    }

    /// A model of so many pixels, from what [`Self::to_bytes`] gave.
    pub(super) fn from_bytes(bytes: &mut ByteReader<'_>, pixels: usize) -> Option<Self> {
        let channels = bytes.count()?;
        let nonnegative = bytes.u8()? == 1;
        let lambda = bytes.f64()?;
        let columns = bytes.f64s(channels.checked_mul(pixels)?)?;
        let gram = bytes.f64s(pixels.checked_mul(pixels)?)?;
        let norms = bytes.f64s(pixels)?;
        (channels > 0).then_some(Self {
            channels,
            columns,
            gram,
            norms,
            lambda,
            nonnegative,
        })
    }

    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Number of pixels.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.norms.len()
    }

    /// The column of A of a pixel.
    #[must_use]
    pub fn column(&self, pixel: usize) -> &[f64] {
        &self.columns[pixel * self.channels..(pixel + 1) * self.channels]
    }

    /// Norm of the Jacobian's column of a pixel: x / norm is the change of conductivity.
    #[must_use]
    pub fn norm(&self, pixel: usize) -> f64 {
        self.norms[pixel]
    }

    /// Whether answers are kept at or above zero.
    #[must_use]
    pub fn is_nonnegative(&self) -> bool {
        self.nonnegative
    }

    /// The paper's way: so many accelerated iterations (FISTA: Beck and Teboulle 2009) from zero, in units of A's columns.
    /// Where the budget ends before the optimum, as it does for wide shapes, the answer is less spiky than [`Self::solve`]'s.
    ///
    /// # Panics
    /// If there is not one change a channel.
    #[must_use]
    pub fn accelerated(&self, changes: &[f64], lambda_abs: f64, iterations: usize) -> Vec<f64> {
        assert_eq!(changes.len(), self.channels);
        let pixels = self.pixels();
        let step = 1.0 / self.steepness();
        let (mut x, mut y, mut momentum) = (vec![0.0; pixels], vec![0.0; pixels], 1.0_f64);
        let mut residual = vec![0.0; self.channels];
        for _ in 0..iterations {
            residual.copy_from_slice(changes);
            for (pixel, value) in y.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                axpy(-value, self.column(pixel), &mut residual);
            }
            let next_momentum = 0.5 * (1.0 + libm::sqrt(1.0 + 4.0 * momentum * momentum));
            let carry = (momentum - 1.0) / next_momentum;
            momentum = next_momentum;
            for pixel in 0..pixels {
                let target = y[pixel] + step * dot(self.column(pixel), &residual);
                let next = self.shrunk(target, step * lambda_abs);
                y[pixel] = next + carry * (next - x[pixel]);
                x[pixel] = next;
            }
        }
        x
    }

    /// The weight of the penalty for a frame: a share of max |A' dv|, and never below what noise alone would reach.
    #[must_use]
    pub fn lambda_abs(&self, changes: &[f64], noise: f64) -> f64 {
        let reach = (0..self.pixels())
            .map(|pixel| dot(self.column(pixel), changes).abs())
            .fold(0.0, f64::max);
        (self.lambda * reach).max(NOISE_REACH * noise)
    }

    /// A little above the largest eigenvalue of A' A, by the power method.
    fn steepness(&self) -> f64 {
        let mut x = vec![1.0; self.pixels()];
        let mut size = 0.0;
        for _ in 0..60 {
            let next: Vec<f64> = (0..self.pixels())
                .map(|pixel| dot(self.gram_row(pixel), &x))
                .collect();
            size = libm::sqrt(dot(&next, &next));
            for (x, next) in x.iter_mut().zip(&next) {
                *x = next / size;
            }
        }
        1.001 * size
    }

    /// The proximal step of the penalty.
    fn shrunk(&self, target: f64, weight: f64) -> f64 {
        if self.nonnegative {
            (target - weight).max(0.0)
        } else {
            libm::copysign((target.abs() - weight).max(0.0), target)
        }
    }

    fn gram_row(&self, pixel: usize) -> &[f64] {
        &self.gram[pixel * self.pixels()..(pixel + 1) * self.pixels()]
    }

    /// Solves for relative changes, starting from the state's answer and leaving the new one there. `noise` is the
    /// deviation of a change (0 if unknown).
    ///
    /// # Panics
    /// If there is not one change a channel.
    pub fn solve(&self, changes: &[f64], noise: f64, state: &mut L1State) -> Quality {
        assert_eq!(changes.len(), self.channels);
        state.fit(self.pixels());
        let power: f64 = 0.5 * dot(changes, changes);
        for (pixel, correlation) in state.correlation.iter_mut().enumerate() {
            *correlation = dot(self.column(pixel), changes);
        }
        let reach = state
            .correlation
            .iter()
            .fold(0.0_f64, |most, c| most.max(c.abs()));
        let lambda_abs = (self.lambda * reach).max(NOISE_REACH * noise);
        state.gradient_of_all(self);
        state.working.clear();
        state.in_working.fill(false);
        for pixel in 0..self.pixels() {
            if state.x[pixel] != 0.0 {
                state.working.push(pixel);
                state.in_working[pixel] = true;
            }
        }
        let mut sweeps = 0;
        loop {
            let (objective, duality_gap) = state.quality(self, power, lambda_abs);
            if duality_gap <= GAP * power || sweeps >= ITERATIONS {
                return Quality {
                    objective,
                    duality_gap,
                    lambda_abs,
                    sweeps,
                };
            }
            state.join(self, lambda_abs);
            state.gather(self);
            for _ in 0..SWEEPS {
                state.sweep(self, lambda_abs);
            }
            state.newton(self, lambda_abs);
            state.gradient_of_all(self);
            sweeps += SWEEPS;
        }
    }
}

impl L1State {
    /// The answer, in units of A's columns.
    #[must_use]
    pub fn answer(&self) -> &[f64] {
        &self.x
    }

    fn fit(&mut self, pixels: usize) {
        self.x.resize(pixels, 0.0);
        self.correlation.resize(pixels, 0.0);
        self.gradient.resize(pixels, 0.0);
        self.in_working.resize(pixels, false);
    }

    /// A' (dv - A x) = A' dv - G x.
    fn gradient_of_all(&mut self, model: &L1Model) {
        self.gradient.copy_from_slice(&self.correlation);
        for (pixel, x) in self.x.iter().enumerate() {
            if *x != 0.0 {
                axpy(-x, model.gram_row(pixel), &mut self.gradient);
            }
        }
    }

    /// Objective and duality gap. The dual point is the residual, shrunk until no pixel exceeds lambda.
    fn quality(&self, model: &L1Model, power: f64, lambda: f64) -> (f64, f64) {
        let fitted = dot(&self.correlation, &self.x);
        let open = dot(&self.gradient, &self.x);
        // |r|2 = |dv|2 - 2 c'x + x'Gx, and x'Gx = x'(c - gradient).
        let residual = (power - 0.5 * (fitted + open)).max(0.0);
        let size: f64 = self.x.iter().map(|x| x.abs()).sum();
        let objective = residual + lambda * size;
        let steepest = self.gradient.iter().fold(0.0_f64, |most, g| {
            most.max(if model.nonnegative { *g } else { g.abs() })
        });
        let shrink = if steepest > lambda {
            lambda / steepest
        } else {
            1.0
        };
        // D(s r) = s dv'r - s2 |r|2 / 2, with dv'r = |dv|2 - c'x.
        let dual = shrink * (2.0 * power - fitted) - shrink * shrink * residual;
        (objective, (objective - dual).max(0.0))
    }

    /// Takes the pixels outside that the gradient pulls hardest into the working set.
    fn join(&mut self, model: &L1Model, lambda: f64) {
        let mut pulled: Vec<(f64, usize)> = self
            .gradient
            .iter()
            .enumerate()
            .map(|(pixel, g)| (if model.nonnegative { *g } else { g.abs() }, pixel))
            .filter(|(pull, pixel)| *pull > lambda && !self.in_working[*pixel])
            .collect();
        pulled.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        for (_, pixel) in pulled.into_iter().take(JOIN) {
            self.working.push(pixel);
            self.in_working[pixel] = true;
        }
    }

    /// Copies the working set's part of the Gram matrix and of the gradient.
    fn gather(&mut self, model: &L1Model) {
        let scratch = &mut self.scratch;
        scratch.gram.clear();
        scratch.gradient.clear();
        for row in &self.working {
            let gram = model.gram_row(*row);
            scratch
                .gram
                .extend(self.working.iter().map(|column| gram[*column]));
            scratch.gradient.push(self.gradient[*row]);
        }
    }

    /// One pass of coordinate descent: each pixel to its own optimum, columns of A having unit norm.
    fn sweep(&mut self, model: &L1Model, lambda: f64) {
        let count = self.working.len();
        for (at, pixel) in self.working.iter().enumerate() {
            let old = self.x[*pixel];
            let target = old + self.scratch.gradient[at];
            let new = model.shrunk(target, lambda);
            if new != old {
                self.x[*pixel] = new;
                let row = &self.scratch.gram[at * count..(at + 1) * count];
                axpy(old - new, row, &mut self.scratch.gradient);
            }
        }
    }

    /// Steps to the optimum of the present support, or as far towards it as no pixel changes sign; pixels that reach
    /// zero leave the support, and it steps again.
    fn newton(&mut self, model: &L1Model, lambda: f64) {
        const STEPS: usize = 8;
        let count = self.working.len();
        for _ in 0..STEPS {
            let scratch = &mut self.scratch;
            scratch.support.clear();
            scratch
                .support
                .extend((0..count).filter(|at| self.x[self.working[*at]] != 0.0));
            let size = scratch.support.len();
            if size == 0 || size > model.channels {
                return;
            }
            scratch.step.clear();
            for at in &scratch.support {
                let sign = self.x[self.working[*at]].signum();
                scratch.step.push(scratch.gradient[*at] - lambda * sign);
            }
            scratch.factor.clear();
            for row in &scratch.support {
                let gram = &scratch.gram[row * count..(row + 1) * count];
                scratch
                    .factor
                    .extend(scratch.support.iter().map(|column| gram[*column]));
            }
            if !solve_in_place(&mut scratch.factor, &mut scratch.step) {
                return;
            }
            let mut share = 1.0;
            let mut leaving = None;
            for (at, step) in scratch.support.iter().zip(&scratch.step) {
                let x = self.x[self.working[*at]];
                if (x + step) * x < 0.0 && -x / step < share {
                    share = -x / step;
                    leaving = Some(self.working[*at]);
                }
            }
            for (at, step) in scratch.support.iter().zip(&scratch.step) {
                let pixel = self.working[*at];
                let old = self.x[pixel];
                let new = if leaving == Some(pixel) {
                    0.0
                } else {
                    old + share * step
                };
                self.x[pixel] = new;
                let row = &scratch.gram[at * count..(at + 1) * count];
                axpy(old - new, row, &mut scratch.gradient);
            }
            if leaving.is_none() {
                return;
            }
        }
    }
}

/// y += a x.
fn axpy(a: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A random but reproducible wide matrix.
    fn matrix(rows: usize, columns: usize, seed: u64) -> Mat<f64> {
        let mut state = seed.wrapping_mul(2).wrapping_add(1);
        Mat::from_fn(rows, columns, |_, _| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.4
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn the_gap_proves_the_answer(seed in 0..1000u64, nonnegative: bool, pixel in 0..60usize) {
            let model = L1Model::new(&matrix(24, 60, seed), 0.05, nonnegative);
            let changes: Vec<f64> = model.column(pixel).iter().map(|a| 0.3 * a).collect();
            let mut state = L1State::default();
            let quality = model.solve(&changes, 0.0, &mut state);
            let power = 0.5 * dot(&changes, &changes);
            prop_assert!(quality.duality_gap <= GAP * power, "{quality:?}");
            if nonnegative {
                prop_assert!(state.answer().iter().all(|x| *x >= 0.0));
            }
            // A column of its own: that pixel stands out.
            let highest = (0..60).max_by(|a, b| state.x[*a].total_cmp(&state.x[*b]));
            prop_assert_eq!(highest, Some(pixel));
        }

        #[test]
        fn a_warm_start_ends_where_a_cold_one_does(seed in 0..1000u64) {
            let model = L1Model::new(&matrix(24, 60, seed), 0.05, true);
            let frame = |share: f64| -> Vec<f64> {
                model.column(3).iter().zip(model.column(40)).map(|(a, b)| 0.3 * a + share * b).collect()
            };
            let (mut warm, mut cold) = (L1State::default(), L1State::default());
            model.solve(&frame(0.1), 0.0, &mut warm);
            let warm = model.solve(&frame(0.2), 0.0, &mut warm);
            let cold = model.solve(&frame(0.2), 0.0, &mut cold);
            prop_assert!((warm.objective - cold.objective).abs() <= 1e-6 * cold.objective.max(1e-9));
        }
    }

    #[test]
    fn below_the_noise_there_is_nothing() {
        let model = L1Model::new(&matrix(24, 60, 7), 0.01, false);
        let changes: Vec<f64> = model.column(5).iter().map(|a| 1e-4 * a).collect();
        let mut state = L1State::default();
        model.solve(&changes, 1e-3, &mut state);
        assert!(state.answer().iter().all(|x| *x == 0.0));
    }
}
