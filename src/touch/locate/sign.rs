//! What a change of the untouched pad is: touches of the expected sign, touches of the other sign, or fingers that lay on the
//! pad from the start and have lifted.
//!
//! The last two are local and of the same strength, but not of the same shape: a conductive spot bundles the current, an
//! insulating one spreads it. If the reference was taken under a finger, the frame is the untouched pad, and the reference seen
//! from it is a touch of the expected sign. So all are fitted, and the best one wins. The sign of the readings' mean is no
//! substitute: a finger at the edge raises most readings where one in the middle lowers them.

use super::locator::{DOWN_GAIN, Locator};
use super::metric::energy;
use super::recent::REFUSED_GROWTH;
use crate::eit::response::TouchModel;
use crate::pad::TouchSign;

/// Steps of the fit of a single touch.
const FIT_STEPS: usize = 40;
/// Touches of the expected sign that leave less than this many times noise and model error need no rival.
const WELL_REST: f64 = 1.0;
/// The same if they leave less than this share of the frame.
const CLEAR_SHARE: f64 = 0.02;
/// A rival explains at least this many times [`DOWN_GAIN`]: at rest, noise has one more way to look like a touch.
const RIVAL_GAINS: f64 = 2.0;
/// A rival leaves at most this share of what touches of the expected sign leave.
const RIVAL_SHARE: f64 = 0.8;

/// What a change of the untouched pad is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Onset {
    /// Noise, or nothing that fingers explain better than anything else.
    Unclear,
    /// Touches of the expected sign.
    Expected,
    /// Something against it: what touches of the other sign leave, and what the lift of fingers leaves, squared deviations.
    Opposite {
        /// As touches of the other sign.
        as_touches: f64,
        /// As the lift of touches that the reference was taken under.
        as_lift: f64,
        /// Whether one of the two explains the frame so much better than touches of the expected sign that noise cannot be the reason.
        is_clear: bool,
    },
}

/// A frame explained as the lift of fingers that the reference was taken under.
#[derive(Clone, Debug)]
pub struct Lift {
    /// What it leaves, as a multiple of noise and model error.
    pub rest: f64,
    /// Sign of the fingers.
    pub sign: TouchSign,
    /// The fingers.
    fingers: Vec<TouchModel>,
}

impl Locator {
    /// Sign of the touches that are expected.
    #[must_use]
    pub fn sign(&self) -> TouchSign {
        self.bounds.sign
    }

    /// Expects touches of a sign; forgets those of the other one.
    pub fn expect_sign(&mut self, sign: TouchSign) {
        if sign != self.bounds.sign {
            self.bounds.sign = sign;
            self.forget_touches();
        }
    }

    /// Whether the table has touches of both signs.
    #[must_use]
    pub fn knows_both_signs(&self) -> bool {
        self.model.table.has_both_signs()
    }

    /// Explains a frame in which no touch is down yet. `noise` as in [`Locator::locate`].
    pub fn explain_onset(&mut self, changes: &[f32], noise: f64) -> Onset {
        // The search for faint touches in the mean of the last frames goes on.
        let recent = std::mem::take(&mut self.recent);
        let bent = std::mem::take(&mut self.bent);
        let onset = self.judge_onset(changes, noise);
        self.recent = recent;
        self.bent = bent;
        onset
    }

    /// A frame as the lift of all fingers that the reference was taken under. The touches of the fit stay as they are.
    #[must_use]
    pub fn explain_lift(&self, changes: &[f32], noise: f64) -> Lift {
        let before = reference_seen_from(changes);
        let fingers = |sign| {
            let mut copy = self.clone();
            copy.bounds.sign = sign;
            let (_, rest) = copy.explain_alone(&before, noise);
            let fingers = std::mem::take(&mut copy.best.touches);
            Lift {
                rest,
                sign,
                fingers,
            }
        };
        let [expected, opposite] = [self.sign(), self.sign().opposite()].map(fingers);
        if opposite.rest < expected.rest {
            opposite
        } else {
            expected
        }
    }

    /// Searches a frame for touches of the expected sign, as if none were down, and for the fingers of a lift as if they had just
    /// landed: a faint finger that lands changes the readings as one of the other sign that lifts. Returns what they do not explain, as
    /// a multiple of noise and model error. The touches that are down do not change.
    #[must_use]
    pub fn rest_as_touches(&self, changes: &[f32], noise: f64, lift: &Lift) -> f64 {
        let mut copy = self.clone();
        let (left, rest) = copy.explain_alone(changes, noise);
        let landed = |finger: &TouchModel| TouchModel {
            sign: finger.sign.opposite(),
            ..*finger
        };
        let landed: Vec<TouchModel> = lift.fingers.iter().map(landed).collect();
        if lift.sign == self.sign() || landed.is_empty() || left <= 0.0 {
            return rest;
        }
        copy.try_fit(&landed, FIT_STEPS);
        rest * (energy(&copy.trial.residual) / left).min(1.0)
    }

    /// What touches of a sign leave of a frame, as a multiple of noise and model error. The touches that are down do not change.
    #[must_use]
    pub fn rest_as_sign(&self, sign: TouchSign, changes: &[f32], noise: f64) -> f64 {
        let mut copy = self.clone();
        copy.bounds.sign = sign;
        copy.explain_alone(changes, noise).1
    }

    fn judge_onset(&mut self, changes: &[f32], noise: f64) -> Onset {
        self.take_frame(changes, noise);
        let before = energy(&self.frame.coordinates);
        if before < RIVAL_GAINS * DOWN_GAIN * noise || before < REFUSED_GROWTH * self.unclear_cost {
            return Onset::Unclear;
        }
        let (expected, rest) = self.explain_alone(changes, noise);
        if rest < WELL_REST || expected < CLEAR_SHARE * before {
            return Onset::Expected;
        }
        let sign = self.bounds.sign;
        self.bounds.sign = sign.opposite();
        let (as_touches, _) = self.explain_alone(changes, noise);
        self.bounds.sign = sign;
        let (as_lift, _) = self.explain_alone(&reference_seen_from(changes), noise);
        let best = as_touches.min(as_lift);
        let gain = before - best;
        if best < RIVAL_SHARE * expected && gain > RIVAL_GAINS * DOWN_GAIN * noise {
            return Onset::Opposite {
                as_touches,
                as_lift,
                is_clear: expected - best > DOWN_GAIN * noise,
            };
        }
        if before - expected > DOWN_GAIN * noise {
            return Onset::Expected;
        }
        self.unclear_cost = before;
        Onset::Unclear
    }

    /// What touches leave of a frame, squared deviations, and as a multiple of noise and model error. Afterwards the touches are the
    /// best trial, and those of the fit are forgotten.
    fn explain_alone(&mut self, changes: &[f32], noise: f64) -> (f64, f64) {
        self.forget_touches();
        self.take_frame(changes, noise);
        self.find_touches(noise, 0.0);
        let quality = self.quality(noise);
        let found = energy(&self.fit.residual);
        self.best.clone_from(&self.fit);
        // A single touch, from several starts and anywhere.
        for place_mm in self
            .model
            .templates
            .peaks(&self.frame.coordinates, self.bounds.sign)
        {
            let touch = self.bounds.typical(place_mm);
            self.try_fit(&[touch], FIT_STEPS);
            if energy(&self.trial.residual) < energy(&self.best.residual) {
                std::mem::swap(&mut self.trial, &mut self.best);
            }
        }
        let left = energy(&self.best.residual);
        self.forget_touches();
        (left, quality.rest * left / found.max(f64::MIN_POSITIVE))
    }
}

/// The relative changes of the reference, seen from a frame with these changes that is the untouched pad.
fn reference_seen_from(changes: &[f32]) -> Vec<f32> {
    let seen = |change: &f32| (-change / (1.0 + change)).clamp(-1.0, 1.0);
    changes.iter().map(seen).collect()
}
