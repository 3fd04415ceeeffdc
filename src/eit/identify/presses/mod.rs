//! The pad as it is, from its readings at rest and presses at known places.
//!
//! An untouched pad has fewer independent readings than it has pieces. Each press shows the pad in another state, so some presses tell
//! apart what the readings at rest leave open. The unknowns and their priors are those of the pad at rest. The size and strength of each
//! press, and how far it was beside its place, are unknown too and integrated out: they widen the covariance of that press's readings.
//!
//! Invariant: a press that the pad does not explain tells nothing of it.

mod fitted_press;
mod hand;
mod normal_equations;

use std::sync::OnceLock;

use faer::Mat;

use super::fit::{Estimate, GAIN_SD, LinearModel};
use super::{LINEAR_SHARE, MODEL_ERROR, RunJobs, Search, Trial, sensitivity};
use crate::eit::ForwardError;
use crate::types::PointMm;
use fitted_press::{FittedPress, RestingPad};
use hand::{Finger, Hand};
use normal_equations::{Linearised, NormalEquations};

/// A press of which the model leaves more than this share is another one: at another place, or of two fingers.
const MOST_LEFT: f64 = 0.5;
/// So is one that is farther than this from its place: three times the spread of the least steady hand.
const MOST_BESIDE_MM: f64 = 9.0;
/// Rounds, and steps in which each press is fitted in the first of them and in the others.
const ROUNDS: usize = 3;
const FIRST_STEPS: usize = 4;
const STEPS: usize = 1;

/// A press at a known place.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownPress {
    /// The place, mm.
    pub place_mm: PointMm,
    /// Relative changes of the readings from those at rest, one per channel; not finite for one to leave out.
    pub changes: Vec<f64>,
}

impl Search<'_> {
    /// Improves an estimate from the readings at rest by presses. `noise` is the relative standard deviation of a change. Returns the
    /// numbers of the presses that the pad does not explain, too.
    pub(super) fn refine(
        &self,
        mut estimate: Estimate,
        presses: &[KnownPress],
        noise: f64,
        run: &RunJobs<'_>,
    ) -> Result<(Estimate, Vec<usize>), ForwardError> {
        let mut hand = Hand::unknown(self.drawing.outline.size_mm());
        let typical = |press: &KnownPress| Finger::typical(&hand, press.place_mm);
        let mut fingers: Vec<Finger> = presses.iter().map(typical).collect();
        let mut unexplained = Vec::new();
        for round in 0..ROUNDS {
            let rest = Trial::new(self, estimate.clone())?;
            let cells = sensitivity::of_cells(&rest.solved, &rest.pad, self.sites.len());
            let mut equations = self.equations_at_rest(&rest, &cells, run)?;
            let resting = RestingPad {
                trial: &rest,
                cells: &cells,
                noise,
                hand,
            };
            let steps = if round == 0 { FIRST_STEPS } else { STEPS };
            let fitted: Vec<OnceLock<Result<FittedPress, ForwardError>>> =
                presses.iter().map(|_| OnceLock::new()).collect();
            run(presses.len(), &|job| {
                let fit = resting.fit(&presses[job], fingers[job], steps, &estimate.values);
                let _ = fitted[job].set(fit);
            });
            unexplained.clear();
            let mut explained = Vec::with_capacity(presses.len());
            for (index, fitted) in fitted.into_iter().enumerate() {
                let fitted = fitted.into_inner().expect("every job was run")?;
                fingers[index] = fitted.finger;
                let place_mm = presses[index].place_mm;
                if fitted.left > MOST_LEFT || fitted.finger.distance_mm(place_mm) > MOST_BESIDE_MM {
                    unexplained.push(index);
                } else {
                    equations.merge(&fitted.equations);
                    explained.push((place_mm, fitted.finger));
                }
            }
            hand = hand.learned(&explained);
            estimate = equations.most_likely(&self.prior, &estimate);
        }
        Ok((estimate, unexplained))
    }

    /// What the readings at rest tell, with the board's gain as an unknown of its own.
    fn equations_at_rest(
        &self,
        rest: &Trial,
        cells: &Mat<f64>,
        run: &RunJobs<'_>,
    ) -> Result<NormalEquations, ForwardError> {
        let electrodes = sensitivity::of_electrodes(&rest.pad, run)?;
        let model = LinearModel::new(
            &rest.compared,
            &rest.solved.volts,
            [cells, &electrodes],
            self.deviations,
            MODEL_ERROR.max(LINEAR_SHARE * rest.compared.misfit()),
        );
        let gain = Mat::from_fn(model.gain.len(), 1, |reading, _| model.gain[reading]);
        let mut equations = NormalEquations::empty(self.prior.len());
        equations.add(
            &Linearised {
                slopes: &model.slopes,
                residuals: &model.residuals,
                variances: &model.variances,
                other_slopes: &gain,
                other_deviations: &[GAIN_SD],
            },
            &rest.estimate.values,
        );
        Ok(equations)
    }
}
