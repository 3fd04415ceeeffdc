//! Least-squares fit of touches to a frame.
//!
//! Each touch has four unknowns: x, y, log radius and strength. Radius and strength of a weak touch are nearly one unknown,
//! so the size of a typical finger serves as a weak prior. (Levenberg-Marquardt: More 1978; damping as in Madsen, Nielsen
//! and Tingleff 2004, section 3.2.)

use super::metric::{Metric, Whitened, dot, energy};
use crate::eit::ResponseTable;
use crate::eit::cholesky::solve_in_place;
use crate::eit::response::{MOST_STRENGTH, Response, Shape, TouchModel};
use crate::pad::TouchSign;

/// Unknowns per touch.
const UNKNOWNS: usize = 4;
/// Strength of a typical finger.
const TYPICAL_STRENGTH: f64 = 0.42;
/// Standard deviations of log radius and strength between fingers.
const SPREAD: [f64; 2] = [0.35, 0.3];
/// Standard deviation of how far outside the pad a finger's centre is, mm.
const OUTSIDE_MM: f64 = 1.0;
/// The fit has converged when a step moves no touch further than this, mm, ...
const CONVERGED_STEP_MM: f64 = 0.02;
/// ... and lowers the cost by less than this, squared deviations.
const CONVERGED_GAIN: f64 = 0.5;
/// ... or lowers the cost so little at less damping than this.
const NEGLIGIBLE_DAMPING: f64 = 1e-2;
/// Damping of the first step, its factors after a step that raised or lowered the cost, and its bounds.
const FIRST_DAMPING: f64 = 1e-3;
const DAMPING_GROWTH: f64 = 8.0;
const DAMPING_DECAY: f64 = 5.0;
const LEAST_DAMPING: f64 = 1e-6;
const MOST_DAMPING: f64 = 1e3;
/// A step moves a touch at most this far, mm: beyond, the response is not linear.
const LONGEST_MM: f64 = 6.0;
/// Variance of a coordinate of which the frame shows nothing, mm2.
const UNSEEN_MM2: f64 = 1e6;
/// A step changes log radius and strength by at most this.
const LONGEST: f64 = 0.4;

/// The touches fitted to a frame, with scratch memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Fit {
    /// The touches.
    pub(super) touches: Vec<TouchModel>,
    /// Their responses, whitened.
    pub(super) responses: Vec<Response>,
    /// What the touches leave unexplained, whitened.
    pub(super) residual: Vec<f32>,
    /// Sum of squares of the residual plus the prior's cost.
    pub(super) cost: f64,
    normal: Vec<f64>,
    gradient: Vec<f64>,
    step: Vec<f64>,
    backup: Backup,
}

/// Where touches may be, and of what size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    /// The pad's width and height, mm.
    pub(super) size_mm: [f64; 2],
    /// How far outside the pad's box centres may be, mm.
    pub(super) reach_mm: f64,
    /// Sign of new touches.
    pub(super) sign: TouchSign,
    /// Smallest and largest log radius.
    pub(super) log_radius: [f64; 2],
    /// Log radius of a typical finger.
    pub(super) typical_log_radius: f64,
    /// Weight of the prior: the variance of the noise in the metric's units.
    pub(super) prior_weight: f64,
}

/// What touches are fitted to: a frame and the model of the pad.
#[derive(Clone, Copy)]
pub(super) struct Problem<'a> {
    pub(super) frame: &'a Whitened,
    pub(super) table: &'a ResponseTable,
    pub(super) metric: &'a Metric,
    pub(super) bounds: &'a Bounds,
}

impl Bounds {
    /// A typical finger at a place.
    #[must_use]
    pub(super) fn typical(&self, centre_mm: [f64; 2]) -> TouchModel {
        TouchModel {
            centre_mm,
            log_radius: self.typical_log_radius,
            strength: TYPICAL_STRENGTH,
            sign: self.sign,
            shape: Shape::Round,
        }
    }

    pub(super) fn clamp(&self, touch: &mut TouchModel) {
        for (at, size) in touch.centre_mm.iter_mut().zip(self.size_mm) {
            *at = at.clamp(-self.reach_mm, size + self.reach_mm);
        }
        touch.log_radius = touch
            .log_radius
            .clamp(self.log_radius[0], self.log_radius[1]);
        touch.strength = touch.strength.clamp(0.0, MOST_STRENGTH);
    }

    /// Cost of the deviation from a typical finger on the pad.
    fn prior_cost(&self, touch: &TouchModel) -> f64 {
        let radius = (touch.log_radius - self.typical_log_radius) / SPREAD[0];
        let strength = (touch.strength - TYPICAL_STRENGTH) / SPREAD[1];
        let [x, y] = self.outside_mm(touch).map(|off| off / OUTSIDE_MM);
        self.prior_weight * (radius * radius + strength * strength + x * x + y * y)
    }

    /// How far a centre lies outside the pad's box, mm: negative below, positive above.
    fn outside_mm(&self, touch: &TouchModel) -> [f64; 2] {
        [0, 1].map(|k| {
            let at = touch.centre_mm[k];
            at - at.clamp(0.0, self.size_mm[k])
        })
    }
}

impl Fit {
    /// Sets the touches and explains a frame by them.
    pub(super) fn set_touches(&mut self, touches: &[TouchModel], problem: Problem<'_>) {
        self.touches.clear();
        self.touches.extend_from_slice(touches);
        for touch in &mut self.touches {
            problem.bounds.clamp(touch);
        }
        self.explain(problem);
    }

    /// Moves the touches to the nearest minimum of the cost, in at most `most_steps` steps.
    pub(super) fn descend(&mut self, most_steps: usize, problem: Problem<'_>) {
        let mut backup = std::mem::take(&mut self.backup);
        let mut damping = FIRST_DAMPING;
        for _ in 0..most_steps {
            if self.touches.is_empty() || !self.solve(damping, problem.bounds) {
                break;
            }
            let step_mm = self.longest_step_mm();
            backup.save(self);
            self.apply_step(problem.bounds);
            self.explain(problem);
            let gain = backup.cost - self.cost;
            if gain < 0.0 {
                backup.restore(self);
                damping *= DAMPING_GROWTH;
                if damping > MOST_DAMPING {
                    break;
                }
                continue;
            }
            let is_undamped = damping < NEGLIGIBLE_DAMPING;
            damping = (damping / DAMPING_DECAY).max(LEAST_DAMPING);
            if gain < CONVERGED_GAIN && (is_undamped || step_mm < CONVERGED_STEP_MM) {
                break;
            }
        }
        self.backup = backup;
    }

    /// Variances of a touch's coordinates x and y, mm2, where a reading has the variance of the weights: the inverse of its
    /// normal matrix, radius and strength unknown as well.
    pub(super) fn variances_mm2(&self, index: usize) -> [f64; 2] {
        let columns = &self.responses[index].derivatives;
        let mut normal = [0.0; UNKNOWNS * UNKNOWNS];
        for row in 0..UNKNOWNS {
            for other in 0..UNKNOWNS {
                normal[row * UNKNOWNS + other] = f64::from(dot(&columns[row], &columns[other]));
            }
        }
        normal[2 * (UNKNOWNS + 1)] += 1.0 / (SPREAD[0] * SPREAD[0]);
        normal[3 * (UNKNOWNS + 1)] += 1.0 / (SPREAD[1] * SPREAD[1]);
        [0, 1].map(|axis| {
            let mut factors = normal;
            let mut unit = [0.0; UNKNOWNS];
            unit[axis] = 1.0;
            let is_seen = solve_in_place(&mut factors, &mut unit) && unit[axis] > 0.0;
            // At the end of the table's reach the response may not depend on the place.
            if is_seen {
                unit[axis].min(UNSEEN_MM2)
            } else {
                UNSEEN_MM2
            }
        })
    }

    /// Moves the touches by the step.
    fn apply_step(&mut self, bounds: &Bounds) {
        for (touch, step) in self
            .touches
            .iter_mut()
            .zip(self.step.chunks_exact(UNKNOWNS))
        {
            let scale = step_scale(step);
            touch.centre_mm[0] += scale * step[0];
            touch.centre_mm[1] += scale * step[1];
            touch.log_radius += scale * step[2];
            touch.strength += scale * step[3];
            bounds.clamp(touch);
        }
    }

    /// The touch with the smallest share of its response left in the frame (1: all of it, 0: none), and that share.
    pub(super) fn least_remaining(&self) -> Option<(usize, f64)> {
        self.responses
            .iter()
            .map(|response| {
                let own = energy(&response.value).max(f64::MIN_POSITIVE);
                1.0 + f64::from(dot(&response.value, &self.residual)) / own
            })
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Computes responses, residual and cost of the touches.
    fn explain(&mut self, problem: Problem<'_>) {
        let Problem {
            frame,
            table,
            metric,
            bounds,
        } = problem;
        self.responses
            .resize_with(self.touches.len(), Response::default);
        self.residual.clear();
        self.residual.extend_from_slice(&frame.coordinates);
        let mut prior = 0.0;
        for (touch, response) in self.touches.iter().zip(&mut self.responses) {
            table.respond(touch, response);
            metric.whiten_response(response);
            for (rest, value) in self.residual.iter_mut().zip(&response.value) {
                *rest -= value;
            }
            prior += bounds.prior_cost(touch);
        }
        self.cost = energy(&self.residual) + prior;
    }

    /// Computes the damped Gauss-Newton step; false if there is none.
    fn solve(&mut self, damping: f64, bounds: &Bounds) -> bool {
        let count = UNKNOWNS * self.touches.len();
        self.normal.clear();
        self.normal.resize(count * count, 0.0);
        self.gradient.clear();
        let column = |index: usize| &self.responses[index / UNKNOWNS].derivatives[index % UNKNOWNS];
        for row in 0..count {
            for other in 0..=row {
                self.normal[row * count + other] = f64::from(dot(column(row), column(other)));
            }
            self.gradient
                .push(f64::from(dot(column(row), &self.residual)));
        }
        for (index, touch) in self.touches.iter().enumerate() {
            let typical = [bounds.typical_log_radius, TYPICAL_STRENGTH];
            for (k, at) in [touch.log_radius, touch.strength].into_iter().enumerate() {
                let row = UNKNOWNS * index + 2 + k;
                let weight = bounds.prior_weight / (SPREAD[k] * SPREAD[k]);
                self.normal[row * count + row] += weight;
                self.gradient[row] += weight * (typical[k] - at);
            }
            for (k, off_mm) in bounds.outside_mm(touch).into_iter().enumerate() {
                if off_mm != 0.0 {
                    let row = UNKNOWNS * index + k;
                    let weight = bounds.prior_weight / (OUTSIDE_MM * OUTSIDE_MM);
                    self.normal[row * count + row] += weight;
                    self.gradient[row] -= weight * off_mm;
                }
            }
        }
        self.pin_at_bounds(bounds);
        for row in 0..count {
            let diagonal = &mut self.normal[row * count + row];
            *diagonal += damping * *diagonal + f64::MIN_POSITIVE;
        }
        self.step.clear();
        self.step.extend_from_slice(&self.gradient);
        solve_in_place(&mut self.normal, &mut self.step)
            && self.step.iter().all(|value| value.is_finite())
    }

    /// Takes unknowns that are at their bound, and would leave it, out of the step: cut off after the step, they would spoil it
    /// for the others. Fits to tables that end at the edge stay as they were.
    fn pin_at_bounds(&mut self, bounds: &Bounds) {
        if bounds.reach_mm <= 0.0 {
            return;
        }
        let count = self.gradient.len();
        for (index, touch) in self.touches.iter().enumerate() {
            let limits = [
                (touch.log_radius, bounds.log_radius),
                (touch.strength, [0.0, MOST_STRENGTH]),
            ];
            for (k, (at, [least, most])) in limits.into_iter().enumerate() {
                let row = UNKNOWNS * index + 2 + k;
                let leaves = at <= least && self.gradient[row] < 0.0
                    || at >= most && self.gradient[row] > 0.0;
                if leaves {
                    for other in 0..count {
                        self.normal[row * count + other] = 0.0;
                        self.normal[other * count + row] = 0.0;
                    }
                    self.normal[row * count + row] = 1.0;
                    self.gradient[row] = 0.0;
                }
            }
        }
    }

    /// Largest distance by which the step moves a touch, mm.
    fn longest_step_mm(&self) -> f64 {
        self.step
            .chunks_exact(UNKNOWNS)
            .map(|step| step_scale(step) * libm::hypot(step[0], step[1]))
            .fold(0.0, f64::max)
    }
}

/// The factor that keeps a touch's step within [`LONGEST_MM`] and [`LONGEST`].
fn step_scale(step: &[f64]) -> f64 {
    let far = libm::hypot(step[0], step[1]) / LONGEST_MM;
    let much = step[2].abs().max(step[3].abs()) / LONGEST;
    1.0 / far.max(much).max(1.0)
}

/// The state before a step, to go back to.
#[derive(Clone, Debug, Default)]
struct Backup {
    touches: Vec<TouchModel>,
    responses: Vec<Response>,
    residual: Vec<f32>,
    cost: f64,
}

impl Backup {
    fn save(&mut self, fit: &mut Fit) {
        self.touches.clone_from(&fit.touches);
        std::mem::swap(&mut self.responses, &mut fit.responses);
        std::mem::swap(&mut self.residual, &mut fit.residual);
        self.cost = fit.cost;
    }

    fn restore(&mut self, fit: &mut Fit) {
        fit.touches.clone_from(&self.touches);
        std::mem::swap(&mut self.responses, &mut fit.responses);
        std::mem::swap(&mut self.residual, &mut fit.residual);
        fit.cost = self.cost;
    }
}
