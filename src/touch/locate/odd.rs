//! One finger of odd shape: a long one, a ring pressed so hard that its middle is lifted, one wider than the table, or the heel of a
//! hand.
//!
//! Two touches close together explain such a finger nearly as well as they explain two fingers. So before one touch becomes two, a
//! finger of odd shape is fitted in their place, and the two count only if they explain the frame better.

use super::fit::Bounds;
use super::locator::Locator;
use super::metric::{Whitened, dot, energy};
use super::model::LocatorModel;
use crate::eit::cholesky::{add_scaled, solve_in_place};
use crate::eit::response::{
    MOST_STRENGTH, SHAPE_UNKNOWNS, Shape, ShapedResponse, StretchResponse, TouchModel,
};
use crate::types::PointMm;

/// Unknowns of a round touch, and of one of any shape.
const ROUND_UNKNOWNS: usize = 4;
const UNKNOWNS: usize = ROUND_UNKNOWNS + SHAPE_UNKNOWNS;
/// Half length of the long fingers, and radii of the rings, that the fits start from, mm.
const LONG_MM: f64 = 7.0;
const RINGS_MM: [f64; 2] = [4.0, 6.5];
/// Half width of palms that they start from, mm.
const PALM_WIDTH_MM: f64 = 3.0;
/// Least half length of a palm between the middles of its outermost parts, mm.
const LEAST_PALM_MM: f64 = 7.5;
/// Stretch and middle that they start from.
const STRETCH: f64 = 0.1;
const MIDDLE: f64 = 0.0;
/// Strength that they start from.
const STRENGTH: f64 = 0.25;
/// Steps of the fit that ranks the starts; ...
const FIRST_STEPS: usize = 4;
/// ... so many of them are fitted in up to this many steps more.
const FITTED: usize = 4;
const STEPS: usize = 20;
/// Damping of the first step, and its factors.
const FIRST_DAMPING: f64 = 1e-2;
const DAMPING_GROWTH: f64 = 8.0;
const DAMPING_DECAY: f64 = 4.0;
const MOST_DAMPING: f64 = 1e3;
/// A step that lowers the cost by less than this, squared deviations, is the last.
const CONVERGED_GAIN: f64 = 0.5;
/// A step changes each unknown by at most this: x and y (mm), log radius, strength, and those of the shape (mm, mm, and none).
const LONGEST: [f64; UNKNOWNS] = [4.0, 4.0, 0.3, 0.3, 4.0, 4.0, 0.5];
/// Most that two fingers beside each other saturate each other, as a stretch along the line between them.
const MOST_INTERACTION: f64 = 0.5;

/// A finger of odd shape, and what it leaves of a residual.
#[derive(Clone, Debug)]
pub(super) struct OddFinger {
    pub(super) touch: TouchModel,
    pub(super) cost: f64,
}

impl Locator {
    /// The finger of odd shape between two places that leaves least of a residual, which is whitened and without the other
    /// touches.
    pub(super) fn odd_finger(&self, target: &[f32], ends_mm: [PointMm; 2]) -> OddFinger {
        let [a, b] = ends_mm;
        let along = libm::atan2(b[1] - a[1], b[0] - a[0]);
        let [narrow, wide] = self.bounds.log_radius;
        let start = |log_radius: f64, shape: Shape| TouchModel {
            centre_mm: [0, 1].map(|k| 0.5 * (a[k] + b[k])),
            log_radius,
            strength: STRENGTH,
            sign: self.bounds.sign,
            shape,
        };
        let long = |quarters: f64| {
            let angle = along + quarters * std::f64::consts::FRAC_PI_4;
            let shape = Shape::Long {
                half_mm: [LONG_MM * libm::cos(angle), LONG_MM * libm::sin(angle)],
                stretch: STRETCH,
            };
            start(self.bounds.typical_log_radius - 0.15, shape)
        };
        let ring = |radius_mm: f64, log_radius: f64| {
            let shape = Shape::Ring {
                radius_mm,
                middle: MIDDLE,
            };
            start(log_radius, shape)
        };
        let starts = [
            long(0.0),
            long(1.0),
            long(2.0),
            long(3.0),
            ring(RINGS_MM[0], narrow),
            ring(RINGS_MM[1], narrow),
            ring(RINGS_MM[1], wide),
        ];
        let frame = Whitened {
            coordinates: target.to_vec(),
            energy: energy(target),
        };
        let mut search = Search {
            frame: &frame,
            model: &self.model,
            bounds: &self.bounds,
            shaped: ShapedResponse::default(),
        };
        let finger = search.best_of(starts);
        if finger.cost < self.model.error_energy(frame.energy) {
            return finger;
        }
        let palm = |quarters: f64| {
            let angle = along + quarters * std::f64::consts::FRAC_PI_4;
            let shape = Shape::Palm {
                half_mm: [LONG_MM * libm::cos(angle), LONG_MM * libm::sin(angle)],
                width_mm: PALM_WIDTH_MM,
            };
            start(wide, shape)
        };
        let palm = search.best_of([palm(0.0), palm(1.0), palm(2.0), palm(3.0)]);
        // A short one is two fingers, one for each of its rows.
        let [x, y, _] = palm.touch.shape.unknowns();
        match libm::hypot(x, y) > LEAST_PALM_MM {
            true => better(finger, palm),
            false => finger,
        }
    }

    /// By how much the cost of the best trial falls if two of its touches saturate each other, to first order: two fingers beside each
    /// other are like one long finger in that.
    pub(super) fn interaction_gain(&self, pair: [usize; 2]) -> f64 {
        let Some(interaction) = self.interaction(pair) else {
            return 0.0;
        };
        // What the unknowns of the touches do not explain of it.
        let columns: Vec<&[f32]> = pair
            .iter()
            .flat_map(|index| &self.best.responses[*index].derivatives)
            .map(Vec::as_slice)
            .collect();
        let count = columns.len();
        let mut normal = vec![0.0; count * count];
        let mut shares: Vec<f64> = columns
            .iter()
            .map(|column| f64::from(dot(column, &interaction)))
            .collect();
        for (row, column) in columns.iter().enumerate() {
            for (other, by) in columns[..=row].iter().enumerate() {
                normal[row * count + other] = f64::from(dot(column, by));
            }
            normal[row * count + row] *= 1.0 + 1e-6;
            normal[row * count + row] += f64::MIN_POSITIVE;
        }
        if !solve_in_place(&mut normal, &mut shares) {
            return 0.0;
        }
        let mut own = interaction;
        for (column, share) in columns.iter().zip(&shares) {
            add_scaled(&mut own, column, -*share as f32);
        }
        let along = f64::from(dot(&own, &self.best.residual));
        let square = energy(&own).max(f64::MIN_POSITIVE);
        let size = (along / square).clamp(0.0, MOST_INTERACTION);
        size * (2.0 * along - size * square)
    }

    /// The response to a stretch of two touches along the line between them, whitened.
    fn interaction(&self, pair: [usize; 2]) -> Option<Vec<f32>> {
        let [a, b] = pair.map(|index| self.best.touches[index].centre_mm);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let square = (dx * dx + dy * dy).max(f64::MIN_POSITIVE);
        let axis = [(dx * dx - dy * dy) / square, 2.0 * dx * dy / square];
        let mut sum = vec![0.0; self.model.table.rank()];
        let mut stretch = StretchResponse::default();
        for index in pair {
            let touch = &self.best.touches[index];
            if !self
                .model
                .table
                .respond_to_stretch(touch.centre_mm, &mut stretch)
            {
                return None;
            }
            let size = libm::exp(2.0 * touch.log_radius) * touch.strength;
            for ([vector, ..], share) in stretch.axes.iter().zip(axis) {
                add_scaled(&mut sum, vector, (size * share) as f32);
            }
        }
        self.model.metric.whiten_coordinates(&mut sum);
        Some(sum)
    }
}

/// Fits fingers of odd shape to a frame.
struct Search<'a> {
    frame: &'a Whitened,
    model: &'a LocatorModel,
    bounds: &'a Bounds,
    shaped: ShapedResponse,
}

/// What a finger leaves, and its derivatives.
struct Explained {
    cost: f64,
    residual: Vec<f32>,
    derivatives: [Vec<f32>; UNKNOWNS],
}

fn better(one: OddFinger, other: OddFinger) -> OddFinger {
    if other.cost < one.cost { other } else { one }
}

impl Search<'_> {
    /// The best fit from some starts.
    fn best_of<const STARTS: usize>(&mut self, starts: [TouchModel; STARTS]) -> OddFinger {
        let mut tried = starts.map(|touch| self.fit(touch, FIRST_STEPS));
        tried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let first = self.fit(tried[0].touch, STEPS);
        let others = tried.into_iter().skip(1).take(FITTED - 1);
        others.fold(first, |best, other| {
            better(best, self.fit(other.touch, STEPS))
        })
    }

    fn fit(&mut self, start: TouchModel, most_steps: usize) -> OddFinger {
        let mut touch = start;
        let mut now = self.explain(&touch);
        let mut damping = FIRST_DAMPING;
        for _ in 0..most_steps {
            let Some(step) = step(&now, damping) else {
                break;
            };
            let next_touch = moved(&touch, step, self.bounds);
            let next = self.explain(&next_touch);
            if next.cost < now.cost {
                let gain = now.cost - next.cost;
                (touch, now) = (next_touch, next);
                damping /= DAMPING_DECAY;
                if gain < CONVERGED_GAIN {
                    break;
                }
            } else {
                damping *= DAMPING_GROWTH;
                if damping > MOST_DAMPING {
                    break;
                }
            }
        }
        OddFinger {
            touch,
            cost: now.cost,
        }
    }

    fn explain(&mut self, touch: &TouchModel) -> Explained {
        let metric = &self.model.metric;
        let shaped = &mut self.shaped;
        self.model.table.respond_shaped(touch, shaped);
        metric.whiten_response(&mut shaped.response);
        for values in &mut shaped.by_shape {
            metric.whiten_coordinates(values);
        }
        let mut residual = self.frame.coordinates.clone();
        add_scaled(&mut residual, &shaped.response.value, -1.0);
        let derivatives = shaped.response.derivatives.iter().chain(&shaped.by_shape);
        let mut derivatives = derivatives.cloned();
        Explained {
            cost: energy(&residual),
            residual,
            derivatives: std::array::from_fn(|_| derivatives.next().unwrap_or_default()),
        }
    }
}

fn moved(touch: &TouchModel, step: [f64; UNKNOWNS], bounds: &Bounds) -> TouchModel {
    let [x, y, log_radius, strength, by_shape @ ..] = step;
    let shape = touch.shape.unknowns();
    let mut moved = TouchModel {
        centre_mm: [touch.centre_mm[0] + x, touch.centre_mm[1] + y],
        log_radius: touch.log_radius + log_radius,
        strength: (touch.strength + strength).clamp(0.0, MOST_STRENGTH),
        shape: touch
            .shape
            .with_unknowns(std::array::from_fn(|k| shape[k] + by_shape[k])),
        ..*touch
    };
    bounds.clamp(&mut moved);
    moved
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
    let far = step.iter().zip(LONGEST);
    let far = far.fold(1.0f64, |most, (by, longest)| most.max(by.abs() / longest));
    (is_solved && step.iter().all(|by| by.is_finite())).then(|| step.map(|by| by / far))
}
