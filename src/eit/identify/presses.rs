//! The pad as it is, from its readings at rest and presses at known places.
//!
//! An untouched pad has fewer independent readings than it has pieces. Each press shows the pad in another state, so some presses tell
//! apart what the readings at rest leave open. The unknowns and their priors are those of the pad at rest; the size and strength of each press, and how
//! far it was beside its place, are unknown too and integrated out: they widen the covariance of that press's readings.
//!
//! With A the sum of J' R^-1 J over rest and presses and b that of J' R^-1 y, the estimate is (S^-1 + A)^-1 b, and the evidence is
//! (b' (S^-1 + A)^-1 b - log|S| - log|S^-1 + A|) / 2 but for a constant (Bishop 2006, 3.5). Unknowns are fewer than readings here.

use std::sync::OnceLock;

use faer::linalg::solvers::{DenseSolveCore, Llt, Solve};
use faer::{Mat, Side};

use super::fit::{Estimate, LinearModel, usual};
use super::{LINEAR_SHARE, MODEL_ERROR, RunJobs, Search, Trial, sensitivity};
use crate::eit::{ForwardError, PRESS_UNKNOWNS, Press, conductivity_factor, element_jacobian};
use crate::pad::TouchSign;
use crate::types::PointMm;

/// Radius of a typical finger as a share of the pad's longer side, and its rise.
const RADIUS_SHARE: f64 = 0.07;
const RISE: f64 = 1.0;
/// A hand that is not known yet: standard deviations of how far each coordinate is beside the place, mm, and of the logarithms of radius
/// and rise. ...
const UNKNOWN_HAND: [f64; PRESS_UNKNOWNS] = [0.5, 0.5, 0.3, 0.6];
/// ... Those of the known one are within these limits.
const STEADIEST: [f64; PRESS_UNKNOWNS] = [0.1, 0.1, 0.08, 0.15];
const LEAST_STEADY: [f64; PRESS_UNKNOWNS] = [3.0, 3.0, 0.35, 0.8];
/// A press of which the model leaves more than this share is another one: at another place, or of two fingers.
const MOST_LEFT: f64 = 0.5;
/// The forward model's own error as a share of a press's changes: of each, and of their root mean square.
const OWN_ERROR: f64 = 0.02;
const COMMON_ERROR: f64 = 0.02;
/// Rounds, and steps in which each press is fitted in the first of them and in the others.
const ROUNDS: usize = 3;
const FIRST_STEPS: usize = 4;
const STEPS: usize = 1;
/// A step changes the logarithms of radius and rise by at most this.
const LONGEST: f64 = 0.4;
/// Factors of a component's deviations that are tried, relative to the present one.
const TIMES: [f64; 4] = [0.4, 0.7, 1.4, 2.5];

/// A press at a known place.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownPress {
    /// The place, mm.
    pub place_mm: PointMm,
    /// Relative changes of the readings from those at rest, one per channel; not finite for one to leave out.
    pub changes: Vec<f64>,
}

impl Search<'_> {
    /// Improves an estimate from the readings at rest by presses. `noise` is the relative deviation of a change. Returns the presses that
    /// the pad does not explain, too: they do not count.
    pub(super) fn refine(
        &self,
        mut estimate: Estimate,
        presses: &[KnownPress],
        noise: f64,
        run: &RunJobs<'_>,
    ) -> Result<(Estimate, Vec<usize>), ForwardError> {
        let size_mm = self.drawing.outline.size_mm();
        let mut hand = Hand::unknown(&size_mm);
        let mut fingers: Vec<Finger> = presses.iter().map(|press| hand.finger(press)).collect();
        let mut unexplained = Vec::new();
        for round in 0..ROUNDS {
            let rest = Trial::new(self, estimate.clone())?;
            let electrodes = sensitivity::of_electrodes(&rest.pad, run)?;
            let cells = sensitivity::of_cells(&rest.solved, &rest.pad, self.sites.len());
            let model = LinearModel::new(
                &rest.compared,
                &rest.solved.volts,
                [&cells, &electrodes],
                self.deviations,
                MODEL_ERROR.max(LINEAR_SHARE * rest.compared.misfit()),
            );
            let mut known = Known::nothing(self.prior.len());
            known.add_rest(&model, &estimate.values);
            let steps = if round == 0 { FIRST_STEPS } else { STEPS };
            let at_rest = AtRest {
                trial: &rest,
                cells: &cells,
                noise,
                hand,
            };
            let shown: Vec<OnceLock<Result<Shown, ForwardError>>> =
                presses.iter().map(|_| OnceLock::new()).collect();
            run(presses.len(), &|job| {
                let finger = fingers[job];
                let _ = shown[job].set(at_rest.shown(&presses[job], finger, steps, &estimate));
            });
            unexplained.clear();
            let mut used = Vec::with_capacity(presses.len());
            for (index, shown) in shown.into_iter().enumerate() {
                let shown = shown.into_inner().expect("every job was run")?;
                fingers[index] = shown.finger;
                if shown.left > MOST_LEFT {
                    unexplained.push(index);
                } else {
                    known.merge(&shown.known);
                    used.push((&presses[index], shown.finger));
                }
            }
            hand = Hand::from_fingers(hand, &used);
            estimate = known.most_likely(self, &estimate);
        }
        Ok((estimate, unexplained))
    }
}

/// How somebody presses: unknowns of a finger are x and y, mm, and the logarithms of radius in mm and rise.
#[derive(Clone, Copy, Debug)]
struct Hand {
    /// Means of the logarithms of radius and rise.
    size: [f64; 2],
    /// Standard deviations of the unknowns.
    deviations: [f64; PRESS_UNKNOWNS],
}

/// One press of a hand.
#[derive(Clone, Copy, Debug)]
struct Finger {
    at: [f64; PRESS_UNKNOWNS],
    /// Variances, with the pad as estimated.
    variances: [f64; PRESS_UNKNOWNS],
    sign: TouchSign,
}

impl Hand {
    fn unknown([width, height]: &[f64; 2]) -> Self {
        let radius_mm = RADIUS_SHARE * width.max(*height);
        Self {
            size: [libm::log(radius_mm), libm::log(RISE)],
            deviations: UNKNOWN_HAND,
        }
    }

    /// The unknowns of a typical press at a place.
    fn typical(&self, press: &KnownPress) -> [f64; PRESS_UNKNOWNS] {
        let ([x, y], [log_radius, log_rise]) = (press.place_mm, self.size);
        [x, y, log_radius, log_rise]
    }

    fn finger(&self, press: &KnownPress) -> Finger {
        Finger {
            at: self.typical(press),
            variances: [0.0; PRESS_UNKNOWNS],
            sign: TouchSign::Rise,
        }
    }

    /// The hand that pressed so (expectation maximisation, one step: Dempster, Laird and Rubin 1977).
    fn from_fingers(before: Self, used: &[(&KnownPress, Finger)]) -> Self {
        if used.is_empty() {
            return before;
        }
        let mean = |of: &dyn Fn(&(&KnownPress, Finger)) -> f64| {
            used.iter().map(of).sum::<f64>() / used.len() as f64
        };
        let size = [2, 3].map(|k| mean(&|(_, finger)| finger.at[k]));
        let hand = Self { size, ..before };
        let spread = |k: usize| {
            mean(&|(press, finger)| {
                let off = finger.at[k] - hand.typical(press)[k];
                off * off + finger.variances[k]
            })
        };
        // Both coordinates alike.
        let place = 0.5 * (spread(0) + spread(1));
        let variances = [place, place, spread(2), spread(3)];
        Self {
            deviations: std::array::from_fn(|k| {
                libm::sqrt(variances[k]).clamp(STEADIEST[k], LEAST_STEADY[k])
            }),
            ..hand
        }
    }
}

impl Finger {
    fn press(&self) -> Press {
        let [x, y, log_radius, log_rise] = self.at;
        Press {
            centre_mm: [x, y],
            radius_mm: libm::exp(log_radius),
            rise: libm::exp(log_rise),
        }
    }
}

/// The pad at rest, as estimated so far.
struct AtRest<'a> {
    trial: &'a Trial,
    /// Channels x cells, V/A per relative change.
    cells: &'a Mat<f64>,
    noise: f64,
    hand: Hand,
}

/// What a press shows.
struct Shown {
    finger: Finger,
    /// Share of the changes that is left.
    left: f64,
    known: Known,
}

/// A press, solved: what it changes, and the derivatives.
struct Pressed {
    fields: crate::eit::Fields,
    /// Conductivity of each triangle, S/m.
    conductivity: Vec<f64>,
    /// Relative changes of the readings.
    changes: Vec<f64>,
    /// Channels x the finger's unknowns.
    by_finger: Mat<f64>,
}

impl AtRest<'_> {
    /// The finger that fits a press best, and what the press tells of the pad.
    fn shown(
        &self,
        press: &KnownPress,
        mut finger: Finger,
        steps: usize,
        estimate: &Estimate,
    ) -> Result<Shown, ForwardError> {
        let variances = self.variances(&press.changes);
        let used: Vec<usize> = (0..variances.len())
            .filter(|channel| variances[*channel].is_finite())
            .collect();
        let mut pressed = self.solve(&finger)?;
        let along = used.iter().map(|c| pressed.changes[*c] * press.changes[*c]);
        if along.sum::<f64>() < 0.0 {
            finger.sign = match finger.sign {
                TouchSign::Rise => TouchSign::Fall,
                TouchSign::Fall => TouchSign::Rise,
            };
            pressed = self.solve(&finger)?;
        }
        for _ in 0..steps {
            let Some(step) = self.step(&mut finger, &pressed, press, &variances) else {
                break;
            };
            for (at, by) in finger.at.iter_mut().zip(step) {
                *at += by;
            }
            pressed = self.solve(&finger)?;
        }
        let square = |of: &dyn Fn(usize) -> f64| used.iter().map(|c| of(*c) * of(*c)).sum::<f64>();
        let rest = square(&|c| press.changes[c] - pressed.changes[c]);
        let left = libm::sqrt(rest / square(&|c| press.changes[c]).max(f64::MIN_POSITIVE));
        let mut known = Known::nothing(estimate.values.len());
        known.add_press(self, press, &finger, &pressed, &variances, &estimate.values);
        Ok(Shown {
            finger,
            left,
            known,
        })
    }

    /// Variances of a press's changes: noise and the model's own error; infinite for those to leave out.
    fn variances(&self, changes: &[f64]) -> Vec<f64> {
        let finite = || changes.iter().filter(|change| change.is_finite());
        let square: f64 = finite().map(|change| change * change).sum();
        let common = COMMON_ERROR * COMMON_ERROR * square / finite().count().max(1) as f64;
        changes
            .iter()
            .map(|change| match change.is_finite() {
                true => {
                    let (noise, own) = (self.noise * (1.0 + change), OWN_ERROR * change);
                    noise * noise + own * own + common
                }
                false => f64::INFINITY,
            })
            .collect()
    }

    /// A Gauss-Newton step of a finger towards the changes of a press. Notes the finger's variances.
    fn step(
        &self,
        finger: &mut Finger,
        pressed: &Pressed,
        press: &KnownPress,
        variances: &[f64],
    ) -> Option<[f64; PRESS_UNKNOWNS]> {
        let used = || (0..variances.len()).filter(|channel| variances[*channel].is_finite());
        let weights = self.hand.deviations.map(|sd| 1.0 / (sd * sd));
        let slope = |channel: usize, unknown: usize| pressed.by_finger[(channel, unknown)];
        let normal = Mat::from_fn(PRESS_UNKNOWNS, PRESS_UNKNOWNS, |i, j| {
            let prior = if i == j { weights[i] } else { 0.0 };
            let parts = used().map(|c| slope(c, i) * slope(c, j) / variances[c]);
            prior + parts.sum::<f64>()
        });
        let typical = self.hand.typical(press);
        let gradient = Mat::from_fn(PRESS_UNKNOWNS, 1, |i, _| {
            let prior = (typical[i] - finger.at[i]) * weights[i];
            let left = |c: usize| press.changes[c] - pressed.changes[c];
            let parts = used().map(|c| slope(c, i) * left(c) / variances[c]);
            prior + parts.sum::<f64>()
        });
        let factor = normal.llt(Side::Lower).ok()?;
        let covariance = factor.inverse();
        finger.variances = std::array::from_fn(|i| covariance[(i, i)]);
        let step = factor.solve(&gradient);
        let far = step[(2, 0)].abs().max(step[(3, 0)].abs()) / LONGEST;
        Some(std::array::from_fn(|i| step[(i, 0)] / far.max(1.0)))
    }

    fn solve(&self, finger: &Finger) -> Result<Pressed, ForwardError> {
        let Trial { pad, solved, .. } = self.trial;
        let press = finger.press();
        let mesh = solved.model.mesh();
        let background = mesh.background_s_per_m(pad);
        let factors =
            mesh.mean_over_triangles(|point| conductivity_factor(&[press], finger.sign, point));
        let conductivity: Vec<f64> = background
            .iter()
            .zip(&factors)
            .map(|(b, f)| b * f)
            .collect();
        let fields = solved.model.solve(&conductivity)?;
        let volts = fields.voltages(&pad.protocol);
        let under: Vec<usize> = (0..factors.len())
            .filter(|triangle| factors[*triangle] != 1.0)
            .collect();
        let slopes = Mat::from_fn(under.len(), PRESS_UNKNOWNS, |row, unknown| {
            let points = mesh.quarter_points_mm(under[row]);
            let scale = match unknown {
                2 => press.radius_mm,
                3 => press.rise,
                _ => 1.0,
            };
            let mean: f64 = points
                .iter()
                .map(|point| {
                    let slope = press.derivatives(*point)[unknown];
                    match finger.sign {
                        TouchSign::Rise => slope,
                        TouchSign::Fall => {
                            let factor = press.factor(*point);
                            -slope / (factor * factor)
                        }
                    }
                })
                .sum();
            scale * background[under[row]] * mean / points.len() as f64
        });
        let mut by_finger =
            element_jacobian(&solved.model, &fields, &pad.protocol, &under) * slopes;
        for (channel, rest) in solved.volts.iter().enumerate() {
            for unknown in 0..PRESS_UNKNOWNS {
                by_finger[(channel, unknown)] /= rest;
            }
        }
        Ok(Pressed {
            changes: volts
                .iter()
                .zip(&solved.volts)
                .map(|(volt, rest)| volt / rest - 1.0)
                .collect(),
            fields,
            conductivity,
            by_finger,
        })
    }
}

/// What readings tell of the unknowns: the normal matrix, and the right-hand side.
struct Known {
    normal: Mat<f64>,
    right: Mat<f64>,
}

impl Known {
    fn nothing(unknowns: usize) -> Self {
        Self {
            normal: Mat::zeros(unknowns, unknowns),
            right: Mat::zeros(unknowns, 1),
        }
    }

    fn merge(&mut self, other: &Self) {
        self.normal += &other.normal;
        self.right += &other.right;
    }

    /// Adds the readings at rest, with the board's gain as an unknown of their own.
    fn add_rest(&mut self, model: &LinearModel, values: &[f64]) {
        let gain = Mat::from_fn(model.gain.len(), 1, |reading, _| model.gain[reading]);
        self.add(
            &model.slopes,
            &model.residuals,
            &model.variances,
            (&gain, &[super::fit::GAIN_SD]),
            values,
        );
    }

    /// Adds a press, with its finger as unknowns of its own.
    fn add_press(
        &mut self,
        at_rest: &AtRest<'_>,
        press: &KnownPress,
        finger: &Finger,
        pressed: &Pressed,
        variances: &[f64],
        values: &[f64],
    ) {
        let Trial { pad, solved, .. } = at_rest.trial;
        let cells = at_rest.cells.ncols();
        let under = sensitivity::of_cells_with(
            &solved.model,
            &pressed.fields,
            pad,
            &pressed.conductivity,
            cells,
        );
        let used: Vec<usize> = (0..variances.len())
            .filter(|channel| variances[*channel].is_finite())
            .collect();
        // Of v / v0 - 1; electrodes change both alike.
        let slopes = Mat::from_fn(used.len(), values.len(), |row, unknown| {
            let channel = used[row];
            if unknown >= cells {
                return 0.0;
            }
            let rest = solved.volts[channel];
            (under[(channel, unknown)]
                - (1.0 + pressed.changes[channel]) * at_rest.cells[(channel, unknown)])
                / rest
        });
        let by_finger = Mat::from_fn(used.len(), PRESS_UNKNOWNS, |row, unknown| {
            pressed.by_finger[(used[row], unknown)]
        });
        let typical = at_rest.hand.typical(press);
        // The finger may be anywhere that its prior allows, not only where it was fitted.
        let residuals: Vec<f64> = used
            .iter()
            .map(|channel| {
                let moved: f64 = (0..PRESS_UNKNOWNS)
                    .map(|k| {
                        let off = finger.at[k] - typical[k];
                        off * pressed.by_finger[(*channel, k)]
                    })
                    .sum();
                press.changes[*channel] - pressed.changes[*channel] + moved
            })
            .collect();
        let used_variances: Vec<f64> = used.iter().map(|channel| variances[*channel]).collect();
        self.add(
            &slopes,
            &residuals,
            &used_variances,
            (&by_finger, &at_rest.hand.deviations),
            values,
        );
    }

    /// Adds readings: their slopes by the unknowns at `values`, what is left of them, their variances, and the slopes of other unknowns with
    /// their standard deviations, which are integrated out (Woodbury).
    fn add(
        &mut self,
        slopes: &Mat<f64>,
        residuals: &[f64],
        variances: &[f64],
        (others, deviations): (&Mat<f64>, &[f64]),
        values: &[f64],
    ) {
        let count = residuals.len();
        let scale: Vec<f64> = variances.iter().map(|v| 1.0 / libm::sqrt(*v)).collect();
        let slopes = Mat::from_fn(count, slopes.ncols(), |i, j| slopes[(i, j)] * scale[i]);
        let others = Mat::from_fn(count, others.ncols(), |i, j| {
            others[(i, j)] * scale[i] * deviations[j]
        });
        let values = Mat::from_fn(values.len(), 1, |i, _| values[i]);
        let mut target = &slopes * values;
        for (i, rest) in residuals.iter().enumerate() {
            target[(i, 0)] += rest * scale[i];
        }
        let mut inner = others.transpose() * &others;
        for k in 0..inner.nrows() {
            inner[(k, k)] += 1.0;
        }
        let Ok(factor) = inner.llt(Side::Lower) else {
            return;
        };
        let cross = others.transpose() * &slopes;
        let along = others.transpose() * &target;
        self.normal += slopes.transpose() * &slopes - cross.transpose() * factor.solve(&cross);
        self.right += slopes.transpose() * &target - cross.transpose() * factor.solve(&along);
    }

    /// The most likely estimate, with the most likely spreads of the prior's components near the present ones.
    fn most_likely(&self, search: &Search<'_>, present: &Estimate) -> Estimate {
        let mut spreads = present.spreads.clone();
        let Some(mut best) = self.weigh(search, &spreads) else {
            return present.clone();
        };
        for component in 0..spreads.len() {
            let from = spreads[component];
            for times in TIMES {
                let mut tried = spreads.clone();
                tried[component] = from * times;
                if let Some(other) = self.weigh(search, &tried).filter(|other| other.0 > best.0) {
                    (best, spreads) = (other, tried);
                }
            }
        }
        Estimate {
            values: best.1.col(0).iter().copied().collect(),
            spreads,
        }
    }

    /// The evidence of the readings with these spreads, and the estimate.
    fn weigh(&self, search: &Search<'_>, spreads: &[f64]) -> Option<(f64, Mat<f64>)> {
        let covariance = search.prior.covariance(spreads);
        let factor = covariance.llt(Side::Lower).ok()?;
        let normal = factor.inverse() + &self.normal;
        let normal = normal.llt(Side::Lower).ok()?;
        let values = normal.solve(&self.right);
        let explained = self.right.transpose() * &values;
        let log = |factor: &Llt<f64>| -> f64 {
            let lower = factor.L();
            (0..lower.nrows())
                .map(|i| 2.0 * libm::log(lower[(i, i)]))
                .sum()
        };
        let evidence = 0.5 * (explained[(0, 0)] - log(&factor) - log(&normal));
        Some((evidence + usual(spreads), values))
    }
}
