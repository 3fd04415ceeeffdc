//! Touches fitted to a frame: the least squares of what the frame reads and what the table says that they read.
//!
//! Each touch has four unknowns: x, y, log radius and strength. Radius and strength are nearly one unknown for a weak
//! touch, so fingers' usual sizes count as a faint measurement of them. (Levenberg-Marquardt: More 1978; the damping follows
//! Madsen, Nielsen and Tingleff 2004, section 3.2.)

use super::metric::{Metric, Whitened, dot};
use crate::eit::ResponseTable;
use crate::eit::cholesky::solve_in_place;
use crate::eit::response::{Bump, MOST_STRENGTH, Response};

/// Unknowns of a touch.
pub(super) const UNKNOWNS: usize = 4;
/// What fingers usually are: log of the radius as a share of the table's middle one, and strength, ...
const USUAL_STRENGTH: f64 = 0.42;
/// ... with these deviations.
const SPREAD: [f64; 2] = [0.35, 0.3];
/// A step is done when it moves no touch further than this, mm, ...
const STILL_MM: f64 = 0.02;
/// ... and lowers the cost by less than this, squared deviations.
const STILL_COST: f64 = 0.5;
/// ... whatever it moves, if it is hardly damped.
const FREE_DAMPING: f64 = 1e-2;
/// Damping of the first step; how it grows after a step that led uphill and falls after one that led down; its bounds.
const FIRST_DAMPING: f64 = 1e-3;
const HARDER: f64 = 8.0;
const EASIER: f64 = 5.0;
const LEAST_DAMPING: f64 = 1e-6;
const MOST_DAMPING: f64 = 1e3;
/// A step moves a touch at most so far, mm: the response is no line beyond.
const LONGEST_MM: f64 = 6.0;
/// A step changes log radius and strength at most by this.
const LONGEST: f64 = 0.4;

/// A frame and what explains it, with scratch memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Fit {
    /// The touches.
    pub(super) bumps: Vec<Bump>,
    /// Their responses, whitened.
    pub(super) responses: Vec<Response>,
    /// What they leave unexplained, whitened.
    pub(super) residual: Vec<f32>,
    /// Sum of the residual's squares and of the squared deviations from what fingers usually are.
    pub(super) cost: f64,
    normal: Vec<f64>,
    gradient: Vec<f64>,
    step: Vec<f64>,
    kept: Kept,
}

/// Where touches are sought, and how large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    /// The pad's width and height, mm.
    pub(super) size_mm: [f64; 2],
    /// Smallest and largest log radius.
    pub(super) log_radius: [f64; 2],
    /// How much a deviation from a usual finger costs: the variance of the noise in the metric's units.
    pub(super) usual_weight: f64,
}

impl Bounds {
    /// Log radius of a usual finger.
    #[must_use]
    pub(super) fn usual_log_radius(&self) -> f64 {
        0.5 * (self.log_radius[0] + self.log_radius[1])
    }

    /// A usual finger at a place.
    #[must_use]
    pub(super) fn usual(&self, centre_mm: [f64; 2]) -> Bump {
        Bump {
            centre_mm,
            log_radius: self.usual_log_radius(),
            strength: USUAL_STRENGTH,
        }
    }

    fn keep(&self, bump: &mut Bump) {
        for (at, size) in bump.centre_mm.iter_mut().zip(self.size_mm) {
            *at = at.clamp(0.0, size);
        }
        bump.log_radius = bump
            .log_radius
            .clamp(self.log_radius[0], self.log_radius[1]);
        bump.strength = bump.strength.clamp(0.0, MOST_STRENGTH);
    }

    /// Squared deviation from a usual finger.
    fn unusual(&self, bump: &Bump) -> f64 {
        let radius = (bump.log_radius - self.usual_log_radius()) / SPREAD[0];
        let strength = (bump.strength - USUAL_STRENGTH) / SPREAD[1];
        self.usual_weight * (radius * radius + strength * strength)
    }
}

impl Fit {
    /// Takes touches as they are and explains a frame by them.
    pub(super) fn start(
        &mut self,
        bumps: &[Bump],
        frame: &Whitened,
        table: &ResponseTable,
        metric: &Metric,
        bounds: &Bounds,
    ) {
        self.bumps.clear();
        self.bumps.extend_from_slice(bumps);
        for bump in &mut self.bumps {
            bounds.keep(bump);
        }
        self.explain(frame, table, metric, bounds);
    }

    /// Moves the touches to where the cost is least; returns the number of steps.
    pub(super) fn descend(
        &mut self,
        most_steps: usize,
        frame: &Whitened,
        table: &ResponseTable,
        metric: &Metric,
        bounds: &Bounds,
    ) -> usize {
        let mut kept = std::mem::take(&mut self.kept);
        let mut damping = FIRST_DAMPING;
        let mut taken = 0;
        while taken < most_steps && !self.bumps.is_empty() && self.solve(damping, bounds) {
            taken += 1;
            let reach_mm = self.longest_mm();
            kept.keep(self);
            self.step_on(bounds);
            self.explain(frame, table, metric, bounds);
            let gain = kept.cost - self.cost;
            if gain < 0.0 {
                kept.restore(self);
                damping *= HARDER;
                if damping > MOST_DAMPING {
                    break;
                }
                continue;
            }
            let is_free = damping < FREE_DAMPING;
            damping = (damping / EASIER).max(LEAST_DAMPING);
            if gain < STILL_COST && (is_free || reach_mm < STILL_MM) {
                break;
            }
        }
        self.kept = kept;
        taken
    }

    /// Moves the touches by the step.
    fn step_on(&mut self, bounds: &Bounds) {
        for (bump, step) in self.bumps.iter_mut().zip(self.step.chunks_exact(UNKNOWNS)) {
            let scale = shortened(step);
            bump.centre_mm[0] += scale * step[0];
            bump.centre_mm[1] += scale * step[1];
            bump.log_radius += scale * step[2];
            bump.strength += scale * step[3];
            bounds.keep(bump);
        }
    }

    /// The touch whose response is least in the frame, and which share of it is: 1 as it was, 0 if it has gone.
    pub(super) fn least_left(&self) -> Option<(usize, f64)> {
        self.responses
            .iter()
            .map(|response| {
                let own = super::metric::energy(&response.value).max(f64::MIN_POSITIVE);
                1.0 + f64::from(dot(&response.value, &self.residual)) / own
            })
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Responses, residual and cost of the touches as they are.
    fn explain(
        &mut self,
        frame: &Whitened,
        table: &ResponseTable,
        metric: &Metric,
        bounds: &Bounds,
    ) {
        self.responses
            .resize_with(self.bumps.len(), Response::default);
        self.residual.clear();
        self.residual.extend_from_slice(&frame.coordinates);
        let mut unusual = 0.0;
        for (bump, response) in self.bumps.iter().zip(&mut self.responses) {
            table.respond(bump, response);
            metric.whiten_response(response);
            for (rest, value) in self.residual.iter_mut().zip(&response.value) {
                *rest -= value;
            }
            unusual += bounds.unusual(bump);
        }
        self.cost = super::metric::energy(&self.residual) + unusual;
    }

    /// The damped Gauss-Newton step; false if there is none.
    fn solve(&mut self, damping: f64, bounds: &Bounds) -> bool {
        let count = UNKNOWNS * self.bumps.len();
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
        for (index, bump) in self.bumps.iter().enumerate() {
            let usual = [bounds.usual_log_radius(), USUAL_STRENGTH];
            for (k, at) in [bump.log_radius, bump.strength].into_iter().enumerate() {
                let row = UNKNOWNS * index + 2 + k;
                let weight = bounds.usual_weight / (SPREAD[k] * SPREAD[k]);
                self.normal[row * count + row] += weight;
                self.gradient[row] += weight * (usual[k] - at);
            }
        }
        for row in 0..count {
            let diagonal = &mut self.normal[row * count + row];
            *diagonal += damping * *diagonal + f64::MIN_POSITIVE;
        }
        self.step.clear();
        self.step.extend_from_slice(&self.gradient);
        solve_in_place(&mut self.normal, &mut self.step)
    }

    /// How far the step would move the touch that it moves furthest, mm.
    fn longest_mm(&self) -> f64 {
        self.step
            .chunks_exact(UNKNOWNS)
            .map(|step| shortened(step) * libm::hypot(step[0], step[1]))
            .fold(0.0, f64::max)
    }
}

/// The factor that brings a touch's step within its bounds.
fn shortened(step: &[f64]) -> f64 {
    let far = libm::hypot(step[0], step[1]) / LONGEST_MM;
    let much = step[2].abs().max(step[3].abs()) / LONGEST;
    1.0 / far.max(much).max(1.0)
}

/// A state to go back to.
#[derive(Clone, Debug, Default)]
struct Kept {
    bumps: Vec<Bump>,
    responses: Vec<Response>,
    residual: Vec<f32>,
    cost: f64,
}

impl Kept {
    fn keep(&mut self, fit: &mut Fit) {
        self.bumps.clone_from(&fit.bumps);
        std::mem::swap(&mut self.responses, &mut fit.responses);
        std::mem::swap(&mut self.residual, &mut fit.residual);
        self.cost = fit.cost;
    }

    fn restore(&mut self, fit: &mut Fit) {
        fit.bumps.clone_from(&self.bumps);
        std::mem::swap(&mut self.responses, &mut fit.responses);
        std::mem::swap(&mut self.residual, &mut fit.residual);
        fit.cost = self.cost;
    }
}
