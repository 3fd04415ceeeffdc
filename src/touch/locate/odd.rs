//! One finger of odd shape: a flat one, or a ring, pressed so hard that its middle is lifted.
//!
//! Two touches close together explain such a finger nearly as well as they explain two fingers. So before one touch becomes two,
//! a ridge and a ring are fitted in their place: rows of touches that share a few unknowns.

use super::fit::Bounds;
use super::locator::Locator;
use super::metric::{Whitened, dot, energy};
use super::model::LocatorModel;
use crate::eit::cholesky::solve_in_place;
use crate::eit::response::{MOST_STRENGTH, Response, TouchModel};
use crate::types::PointMm;

/// Unknowns of a shape.
const UNKNOWNS: usize = 6;
/// Half length of the ridges, and radii of the rings, that the fits start from, mm.
const RIDGE_MM: f64 = 7.0;
const RINGS_MM: [f64; 2] = [4.0, 6.5];
/// Steps of the fit that ranks the starts; ...
const FIRST_STEPS: usize = 4;
/// ... so many of them are fitted in up to this many steps more.
const FITTED: usize = 2;
const STEPS: usize = 20;
/// Damping of the first step, and its factors.
const FIRST_DAMPING: f64 = 1e-2;
const DAMPING_GROWTH: f64 = 8.0;
const DAMPING_DECAY: f64 = 4.0;
/// A step moves a centre by at most this, mm.
const LONGEST_MM: f64 = 4.0;
/// A step changes log radius and strength by at most this.
const LONGEST: f64 = 0.3;
/// Places along a ridge, as multiples of its half length, and their share of the strength.
const RIDGE: [(f64, f64); 3] = [(-1.0, 0.7), (0.0, 1.0), (1.0, 0.7)];
/// Longest half of a ridge, mm: with the finger's radius beside it.
const LONGEST_RIDGE_MM: f64 = 11.0;
/// Places around a ring.
const RING: usize = 6;
/// Widest ring, mm.
const WIDEST_RING_MM: f64 = 9.0;

/// One finger of odd shape.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Centre, half length (x, y), log radius, strength.
    Ridge,
    /// Centre, radius of the ring, unused, log radius of its width, strength.
    Ring,
}

/// Where a part of a shape is, and how it depends on the unknowns.
struct Part {
    touch: TouchModel,
    /// Derivatives of x, y, log radius and strength by each unknown.
    by: [[f64; UNKNOWNS]; 4],
}

impl Kind {
    fn parts(self, at: &[f64; UNKNOWNS], bounds: &Bounds) -> Vec<Part> {
        let sign = bounds.sign;
        let part = |centre_mm: PointMm, strength: f64, by: [[f64; UNKNOWNS]; 4]| Part {
            touch: TouchModel {
                centre_mm,
                log_radius: at[4],
                strength,
                sign,
            },
            by,
        };
        match self {
            Self::Ridge => RIDGE
                .iter()
                .map(|(along, share)| {
                    let centre_mm = [at[0] + along * at[2], at[1] + along * at[3]];
                    part(
                        centre_mm,
                        share * at[5],
                        [
                            [1.0, 0.0, *along, 0.0, 0.0, 0.0],
                            [0.0, 1.0, 0.0, *along, 0.0, 0.0],
                            [0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
                            [0.0, 0.0, 0.0, 0.0, 0.0, *share],
                        ],
                    )
                })
                .collect(),
            Self::Ring => (0..RING)
                .map(|index| {
                    let angle = std::f64::consts::TAU * index as f64 / RING as f64;
                    let (x, y) = (libm::cos(angle), libm::sin(angle));
                    part(
                        [at[0] + x * at[2], at[1] + y * at[2]],
                        at[5],
                        [
                            [1.0, 0.0, x, 0.0, 0.0, 0.0],
                            [0.0, 1.0, y, 0.0, 0.0, 0.0],
                            [0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
                            [0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
                        ],
                    )
                })
                .collect(),
        }
    }

    fn clamp(self, at: &mut [f64; UNKNOWNS], bounds: &Bounds) {
        let [least, most] = bounds.log_radius;
        at[4] = at[4].clamp(least, most);
        at[5] = at[5].clamp(0.0, MOST_STRENGTH);
        match self {
            Self::Ridge => {
                let length = libm::hypot(at[2], at[3]);
                if length > LONGEST_RIDGE_MM {
                    at[2] *= LONGEST_RIDGE_MM / length;
                    at[3] *= LONGEST_RIDGE_MM / length;
                }
            }
            Self::Ring => at[2] = at[2].clamp(0.0, WIDEST_RING_MM),
        }
    }
}

impl Locator {
    /// The least that one odd finger between two places leaves of a residual that is whitened and without the other touches.
    pub(super) fn odd_cost(&mut self, target: &[f32], ends_mm: [PointMm; 2]) -> f64 {
        let [a, b] = ends_mm;
        let middle = [0, 1].map(|k| 0.5 * (a[k] + b[k]));
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let along = libm::atan2(dy, dx);
        let log_radius = self.bounds.typical_log_radius - 0.15;
        let ridge = |turn: f64| {
            let (x, y) = (libm::cos(along + turn), libm::sin(along + turn));
            let half = [x, y].map(|part| RIDGE_MM * part);
            (
                Kind::Ridge,
                [middle[0], middle[1], half[0], half[1], log_radius, 0.3],
            )
        };
        let [narrow, wide] = self.bounds.log_radius;
        let ring = |radius_mm: f64, log_radius: f64| {
            (
                Kind::Ring,
                [middle[0], middle[1], radius_mm, 0.0, log_radius, 0.3],
            )
        };
        let quarter = std::f64::consts::FRAC_PI_4;
        let starts = [
            ridge(0.0),
            ridge(quarter),
            ridge(2.0 * quarter),
            ridge(3.0 * quarter),
            ring(RINGS_MM[0], narrow),
            ring(RINGS_MM[1], narrow),
            ring(RINGS_MM[1], wide),
        ];
        let frame = Whitened {
            coordinates: target.to_vec(),
            energy: energy(target),
        };
        let fit =
            |kind: Kind, start, steps| fit(kind, start, steps, &frame, &self.model, &self.bounds);
        let mut tried = starts.map(|(kind, start)| (kind, fit(kind, start, FIRST_STEPS)));
        tried.sort_by(|a, b| a.1.1.total_cmp(&b.1.1));
        tried[..FITTED]
            .iter()
            .map(|(kind, (at, _))| fit(*kind, *at, STEPS).1)
            .fold(f64::INFINITY, f64::min)
    }
}

/// Fits a shape; returns its unknowns and what it leaves.
fn fit(
    kind: Kind,
    start: [f64; UNKNOWNS],
    steps: usize,
    frame: &Whitened,
    model: &LocatorModel,
    bounds: &Bounds,
) -> ([f64; UNKNOWNS], f64) {
    let mut at = start;
    kind.clamp(&mut at, bounds);
    let mut damping = FIRST_DAMPING;
    let mut now = explain(kind, &at, frame, model, bounds);
    for _ in 0..steps {
        let Some(step) = step(&now, damping) else {
            break;
        };
        let mut next_at = at;
        for (value, by) in next_at.iter_mut().zip(step) {
            *value += by;
        }
        kind.clamp(&mut next_at, bounds);
        let next = explain(kind, &next_at, frame, model, bounds);
        if next.cost < now.cost {
            let gain = now.cost - next.cost;
            (at, now) = (next_at, next);
            damping /= DAMPING_DECAY;
            if gain < 0.5 {
                break;
            }
        } else {
            damping *= DAMPING_GROWTH;
            if damping > 1e3 {
                break;
            }
        }
    }
    (at, now.cost)
}

/// What a shape leaves, and its derivatives.
struct Explained {
    cost: f64,
    residual: Vec<f32>,
    derivatives: [Vec<f32>; UNKNOWNS],
}

fn explain(
    kind: Kind,
    at: &[f64; UNKNOWNS],
    frame: &Whitened,
    model: &LocatorModel,
    bounds: &Bounds,
) -> Explained {
    let rank = frame.coordinates.len();
    let mut residual = frame.coordinates.clone();
    let mut derivatives: [Vec<f32>; UNKNOWNS] = std::array::from_fn(|_| vec![0.0; rank]);
    let mut response = Response::default();
    for part in kind.parts(at, bounds) {
        model.table.respond(&part.touch, &mut response);
        model.metric.whiten_response(&mut response);
        for (rest, value) in residual.iter_mut().zip(&response.value) {
            *rest -= value;
        }
        for (unknown, derivative) in derivatives.iter_mut().enumerate() {
            for (by, own) in part.by.iter().zip(&response.derivatives) {
                let factor = by[unknown] as f32;
                if factor != 0.0 {
                    for (sum, value) in derivative.iter_mut().zip(own) {
                        *sum += factor * value;
                    }
                }
            }
        }
    }
    Explained {
        cost: energy(&residual),
        residual,
        derivatives,
    }
}

/// The damped Gauss-Newton step; `None` if there is none.
fn step(now: &Explained, damping: f64) -> Option<[f64; UNKNOWNS]> {
    let mut normal = vec![0.0; UNKNOWNS * UNKNOWNS];
    let mut step = vec![0.0; UNKNOWNS];
    for row in 0..UNKNOWNS {
        for other in 0..=row {
            normal[row * UNKNOWNS + other] =
                f64::from(dot(&now.derivatives[row], &now.derivatives[other]));
        }
        step[row] = f64::from(dot(&now.derivatives[row], &now.residual));
        let diagonal = &mut normal[row * UNKNOWNS + row];
        *diagonal += damping * *diagonal + 1e-9;
    }
    let is_solved = solve_in_place(&mut normal, &mut step);
    let step: [f64; UNKNOWNS] = step.try_into().ok()?;
    let far = step[..4].iter().fold(0.0f64, |most, by| most.max(by.abs())) / LONGEST_MM;
    let much = step[4].abs().max(step[5].abs()) / LONGEST;
    let scale = 1.0 / far.max(much).max(1.0);
    (is_solved && step.iter().all(|by| by.is_finite())).then(|| step.map(|by| scale * by))
}
