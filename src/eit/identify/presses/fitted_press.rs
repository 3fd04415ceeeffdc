//! One press: the finger that explains it best on the pad as estimated, and what the press then tells of the pad.

use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::{Mat, Side};

use super::KnownPress;
use super::hand::{Finger, Hand};
use super::normal_equations::{Linearised, NormalEquations};
use crate::eit::identify::{Trial, sensitivity};
use crate::eit::{Fields, ForwardError, PRESS_UNKNOWNS, PressedPad, conductivity_factor};
use crate::pad::TouchSign;

/// The forward model's own error as a share of a press's changes: of each, and of their root mean square.
const OWN_ERROR: f64 = 0.02;
const COMMON_ERROR: f64 = 0.02;
/// A step changes the logarithms of radius and rise by at most this.
const LONGEST: f64 = 0.4;

/// The pad at rest, as estimated so far, and the hand that presses it.
pub(super) struct RestingPad<'a> {
    pub(super) trial: &'a Trial,
    /// Channels x cells, V/A per relative change.
    pub(super) cells: &'a Mat<f64>,
    /// Relative standard deviation of a change.
    pub(super) noise: f64,
    pub(super) hand: Hand,
}

/// A press with the finger that explains it best.
pub(super) struct FittedPress {
    pub(super) finger: Finger,
    /// Share of the changes that the finger leaves unexplained.
    pub(super) left: f64,
    /// What the press tells of the pad.
    pub(super) equations: NormalEquations,
}

/// The channels of a press that count, and how sure each of its changes is.
struct Channels {
    used: Vec<usize>,
    /// Variance of the change of each used channel.
    variances: Vec<f64>,
}

impl Channels {
    /// `noise` is the relative standard deviation of a change; the model's own error is added.
    fn of_changes(changes: &[f64], noise: f64) -> Self {
        let used: Vec<usize> = (0..changes.len())
            .filter(|channel| changes[*channel].is_finite())
            .collect();
        let square: f64 = used.iter().map(|c| changes[*c] * changes[*c]).sum();
        let common = COMMON_ERROR * COMMON_ERROR * square / used.len().max(1) as f64;
        let variance = |channel: &usize| {
            let change = changes[*channel];
            let (noise, own) = (noise * (1.0 + change), OWN_ERROR * change);
            noise * noise + own * own + common
        };
        Self {
            variances: used.iter().map(variance).collect(),
            used,
        }
    }

    /// The sum over used channels of a term, which gets the channel.
    fn sum(&self, term: impl Fn(usize) -> f64) -> f64 {
        self.used.iter().map(|channel| term(*channel)).sum()
    }

    /// The same, each term divided by the channel's variance.
    fn weighted_sum(&self, term: impl Fn(usize) -> f64) -> f64 {
        let pairs = self.used.iter().zip(&self.variances);
        pairs
            .map(|(channel, variance)| term(*channel) / variance)
            .sum()
    }
}

/// The pad under a finger, solved.
struct Solution {
    fields: Fields,
    /// Conductivity of each triangle, S/m.
    conductivity: Vec<f64>,
    /// Relative changes of the readings from those at rest.
    changes: Vec<f64>,
    /// Channels x the finger's unknowns.
    by_finger: Mat<f64>,
}

impl RestingPad<'_> {
    /// Fits a finger to a press, in at most so many steps from where it was, about these values of the pad's unknowns.
    pub(super) fn fit(
        &self,
        press: &KnownPress,
        mut finger: Finger,
        steps: usize,
        values: &[f64],
    ) -> Result<FittedPress, ForwardError> {
        let channels = Channels::of_changes(&press.changes, self.noise);
        let mut solution = self.solve(&finger)?;
        if channels.sum(|c| solution.changes[c] * press.changes[c]) < 0.0 {
            finger.sign = match finger.sign {
                TouchSign::Rise => TouchSign::Fall,
                TouchSign::Fall => TouchSign::Rise,
            };
            solution = self.solve(&finger)?;
        }
        for _ in 0..steps {
            let Some(step) = self.step(&mut finger, &solution, press, &channels) else {
                break;
            };
            for (unknown, by) in finger.unknowns.iter_mut().zip(step) {
                *unknown += by;
            }
            solution = self.solve(&finger)?;
        }
        let all = channels.sum(|c| press.changes[c] * press.changes[c]);
        let rest = channels.sum(|c| {
            let left = press.changes[c] - solution.changes[c];
            left * left
        });
        Ok(FittedPress {
            finger,
            // A press without any change is not explained by a finger.
            left: if all > 0.0 {
                libm::sqrt(rest / all)
            } else {
                1.0
            },
            equations: self.equations(press, &finger, &solution, &channels, values),
        })
    }

    /// A Gauss-Newton step of a finger towards the changes of a press. Notes the finger's variances. None if nothing determines it.
    fn step(
        &self,
        finger: &mut Finger,
        solution: &Solution,
        press: &KnownPress,
        channels: &Channels,
    ) -> Option<[f64; PRESS_UNKNOWNS]> {
        let weights = self.hand.deviations.map(|sd| 1.0 / (sd * sd));
        let slope = |channel: usize, unknown: usize| solution.by_finger[(channel, unknown)];
        let normal = Mat::from_fn(PRESS_UNKNOWNS, PRESS_UNKNOWNS, |i, j| {
            let prior = if i == j { weights[i] } else { 0.0 };
            prior + channels.weighted_sum(|c| slope(c, i) * slope(c, j))
        });
        let typical = self.hand.typical(press.place_mm);
        let gradient = Mat::from_fn(PRESS_UNKNOWNS, 1, |i, _| {
            let prior = (typical[i] - finger.unknowns[i]) * weights[i];
            let left = |c: usize| press.changes[c] - solution.changes[c];
            prior + channels.weighted_sum(|c| slope(c, i) * left(c))
        });
        let factor = normal.llt(Side::Lower).ok()?;
        let covariance = factor.inverse();
        finger.variances = std::array::from_fn(|i| covariance[(i, i)]);
        let step = factor.solve(&gradient);
        let far = step[(2, 0)].abs().max(step[(3, 0)].abs()) / LONGEST;
        Some(std::array::from_fn(|i| step[(i, 0)] / far.max(1.0)))
    }

    fn solve(&self, finger: &Finger) -> Result<Solution, ForwardError> {
        let Trial { pad, solved, .. } = self.trial;
        let (presses, sign) = ([finger.press()], finger.sign);
        let mesh = solved.model.mesh();
        let background = mesh.background_s_per_m(pad);
        let factors = mesh.mean_over_triangles(|point| conductivity_factor(&presses, sign, point));
        let pairs = background.iter().zip(&factors);
        let conductivity: Vec<f64> = pairs.map(|(siemens, factor)| siemens * factor).collect();
        let fields = solved.model.solve(&conductivity)?;
        let pressed = PressedPad {
            model: &solved.model,
            fields: &fields,
            background: &background,
            presses: &presses,
            sign,
        };
        let slopes = pressed.slopes(&pad.protocol);
        // A finger's size and strength are known by their logarithms.
        let scales = [1.0, 1.0, presses[0].radius_mm, presses[0].rise];
        let by_finger = Mat::from_fn(slopes.nrows(), PRESS_UNKNOWNS, |channel, unknown| {
            slopes[(channel, unknown)] * scales[unknown] / solved.volts[channel]
        });
        let volts = fields.voltages(&pad.protocol);
        let pairs = volts.iter().zip(&solved.volts);
        Ok(Solution {
            changes: pairs.map(|(volt, rest)| volt / rest - 1.0).collect(),
            fields,
            conductivity,
            by_finger,
        })
    }

    /// What a press tells of the pad, with its finger as unknowns of its own.
    fn equations(
        &self,
        press: &KnownPress,
        finger: &Finger,
        solution: &Solution,
        channels: &Channels,
        values: &[f64],
    ) -> NormalEquations {
        let Trial { pad, solved, .. } = self.trial;
        let cells = self.cells.ncols();
        let under = sensitivity::of_cells_with(
            &solved.model,
            &solution.fields,
            pad,
            &solution.conductivity,
            cells,
        );
        let used = &channels.used;
        // Of v / v0 - 1. Electrodes change both alike.
        let slopes = Mat::from_fn(used.len(), values.len(), |row, unknown| {
            if unknown >= cells {
                return 0.0;
            }
            let channel = used[row];
            let at_rest = (1.0 + solution.changes[channel]) * self.cells[(channel, unknown)];
            (under[(channel, unknown)] - at_rest) / solved.volts[channel]
        });
        let other_slopes = Mat::from_fn(used.len(), PRESS_UNKNOWNS, |row, unknown| {
            solution.by_finger[(used[row], unknown)]
        });
        let typical = self.hand.typical(press.place_mm);
        // The finger may be anywhere that the hand allows, not only where it was fitted.
        let residual = |channel: usize| {
            let moved =
                |k: usize| (finger.unknowns[k] - typical[k]) * solution.by_finger[(channel, k)];
            let moved: f64 = (0..PRESS_UNKNOWNS).map(moved).sum();
            press.changes[channel] - solution.changes[channel] + moved
        };
        let residuals: Vec<f64> = used.iter().map(|channel| residual(*channel)).collect();
        let mut equations = NormalEquations::empty(values.len());
        equations.add(
            &Linearised {
                slopes: &slopes,
                residuals: &residuals,
                variances: &channels.variances,
                other_slopes: &other_slopes,
                other_deviations: &self.hand.deviations,
            },
            values,
        );
        equations
    }
}
