//! Coordinate descent on a working set, with Newton steps.
//!
//! A frame starts from the last one's answer and works on few pixels: coordinate descent on a working set finds the
//! support, and a Newton step on it (a small Cholesky factorisation) jumps to the optimum of that support. The gradient of
//! all pixels, which the Gram matrix gives cheaply, then either names pixels to add or proves by the duality gap that the
//! answer is good. (Coordinate descent: Friedman, Hastie and Tibshirani 2010; gap: Kim et al. 2007, eq. 10-12; working
//! sets: Massias, Gramfort and Salmon 2018.)

use super::model::{ITERATIONS, L1Model, NOISE_REACH};
use crate::eit::cholesky::{add_scaled, dot, solve_in_place};

/// The answer is good when the duality gap is below this share of 1/2 |dv|2.
const GAP: f64 = 1e-7;
/// Sweeps of coordinate descent between two Newton steps.
const SWEEPS: usize = 3;
/// Pixels that join the working set per round.
const JOIN: usize = 24;
/// Most Newton steps per round.
const NEWTON_STEPS: usize = 8;

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
    /// Gram matrix of the working set in row-major order.
    gram: Vec<f64>,
    /// Gradient on the working set.
    gradient: Vec<f64>,
    factor: Vec<f64>,
    support: Vec<usize>,
    step: Vec<f64>,
}

/// Quality of an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// 1/2 |A x - dv|2 + lambda |x|1.
    pub objective: f64,
    /// Upper bound of the distance to the least objective.
    pub duality_gap: f64,
    /// Weight of the penalty.
    pub lambda_abs: f64,
    /// Sweeps over the working set.
    pub sweeps: usize,
}

impl L1Model {
    /// Solves for relative changes, starting from the answer in `state` and storing the new one there. `noise` is the
    /// standard deviation of a change (0 if unknown).
    ///
    /// # Panics
    /// If there is not one change per channel.
    pub fn solve(&self, changes: &[f64], noise: f64, state: &mut L1State) -> Quality {
        assert_eq!(changes.len(), self.channels);
        state.resize(self.pixels());
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

    fn resize(&mut self, pixels: usize) {
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
                add_scaled(&mut self.gradient, model.gram_row(pixel), -x);
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

    /// Adds the pixels with the largest gradient above lambda to the working set.
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

    /// One pass of coordinate descent: moves each pixel to its own optimum (columns of A have unit norm).
    fn sweep(&mut self, model: &L1Model, lambda: f64) {
        let count = self.working.len();
        for (at, pixel) in self.working.iter().enumerate() {
            let old = self.x[*pixel];
            let target = old + self.scratch.gradient[at];
            let new = model.shrunk(target, lambda);
            if new != old {
                self.x[*pixel] = new;
                let row = &self.scratch.gram[at * count..(at + 1) * count];
                add_scaled(&mut self.scratch.gradient, row, old - new);
            }
        }
    }

    /// Steps to the optimum of the present support, or as far towards it as no pixel changes sign; pixels that reach
    /// zero leave the support before the next step.
    fn newton(&mut self, model: &L1Model, lambda: f64) {
        let count = self.working.len();
        for _ in 0..NEWTON_STEPS {
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
                add_scaled(&mut scratch.gradient, row, old - new);
            }
            if leaving.is_none() {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;
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
            // The changes are one column: its pixel is the largest.
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
    fn changes_below_the_noise_give_a_blank_image() {
        let model = L1Model::new(&matrix(24, 60, 7), 0.01, false);
        let changes: Vec<f64> = model.column(5).iter().map(|a| 1e-4 * a).collect();
        let mut state = L1State::default();
        model.solve(&changes, 1e-3, &mut state);
        assert!(state.answer().iter().all(|x| *x == 0.0));
    }
}
