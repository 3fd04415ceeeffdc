//! The sign of touches: whether they raise or lower the conductivity.
//!
//! Real gels do either. A detector expects the sign of the pad's text until a change against it looks like a touch of the other
//! sign; once a touch has come and gone, its sign is known for the session, and a change in the other direction is a finger
//! that had been lying on the pad.
//!
//! Until then the choice between the two may be wrong, so what contradicts it is kept. If the lift of a finger was assumed and
//! the pad later returns to the abandoned reference, to within noise, it was a touch, if it looks like one. If a touch
//! was assumed and another of the first sign appears beside it, or it stays very long, it was a lift.

use std::collections::VecDeque;

use super::Detector;
use crate::eit::{REFERENCE_FRAMES, Reference};
use crate::pad::TouchSign;
use crate::touch::Sensing;
use crate::touch::locate::{Locator, Onset};
use crate::types::{Frame, NANOS_PER_MS, Nanos, Touch};

/// A finger that lies on the pad when play begins is likely to lift within this time; ...
const EARLY_NS: Nanos = 2_000 * NANOS_PER_MS;
/// ... then, a touch has to explain a frame better by this factor, and afterwards the lift has to.
const EARLY: f64 = 1.15;
/// The first touch of an unexpected sign is taken for a lift after all if it stays for so long.
const LONGEST_FIRST_NS: Nanos = 10_000 * NANOS_PER_MS;
/// A frame is back at the abandoned reference if its mean squared deviation from it is below this many variances ...
const BACK_VARIANCES: f64 = 2.5;
/// ... and its distance below this share of that of the present reference.
const BACK_SHARE: f64 = 0.1;
/// A frame with a touch of unexpected sign is contradicted by another touch if this many times noise and model error are left,
/// ...
const CONTRADICTED_REST: f64 = 4.0;

/// Every this many frames, touches on a pad whose reference is not confirmed yet are questioned, ...
const QUESTIONED_FRAMES: u64 = 8;
/// ... if they leave more than this many times noise and model error, ...
const QUESTIONED_REST: f64 = 1.0;
/// ... and were none if the lift of all fingers leaves less than this share of that.
const LIFT_SHARE: f64 = 0.5;

/// What a change of the untouched pad is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Judged {
    /// Nothing that fingers explain.
    Unclear,
    /// A touch begins.
    Touch,
    /// A finger that had been lying on the pad has lifted.
    Lift,
}

/// What is known about the sign of touches.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SignState {
    /// The sign of the touches that are expected.
    pub(super) expected: TouchSign,
    /// Whether touches of either sign are located: the table has both.
    has_both: bool,
    /// A touch of the expected sign has come and gone.
    is_known: bool,
    /// The present choice, which may be wrong.
    tried: Option<Tried>,
}

impl SignState {
    /// Before the first frame of a pad with this sensing.
    pub(super) fn new(sensing: &Sensing) -> Self {
        let mut state = Self {
            expected: sensing.reconstruction.touch_sign(),
            has_both: false,
            is_known: false,
            tried: None,
        };
        state.set_sensing(sensing);
        state
    }

    /// Takes over a sensing of the same pad.
    pub(super) fn set_sensing(&mut self, sensing: &Sensing) {
        let model = sensing.locator_model.as_ref();
        self.has_both = model.is_some_and(|model| model.table().has_both_signs());
    }

    /// The sign is certain: the expected one, or the other one.
    fn decide(&mut self, expected: TouchSign) {
        self.expected = expected;
        self.is_known = true;
        self.tried = None;
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Tried {
    /// A touch of unexpected sign, since a time, with the last frames that it explains alone.
    Touch {
        since_ns: Nanos,
        frames: VecDeque<(Nanos, Vec<f32>)>,
    },
    /// The lift of a finger that had been lying on the pad.
    Lift {
        /// The reference before it.
        old: Box<Reference>,
        /// The last frame that was taken for the untouched pad: what counts as the new reference until that is complete.
        lifted: Vec<f32>,
        /// The sign of touches if it was none: then the pad returns to that reference.
        otherwise: TouchSign,
    },
}

impl Detector {
    /// The sign of the touches that are expected: at first that of the pad's text.
    #[must_use]
    pub fn touch_sign(&self) -> TouchSign {
        self.sign.expected
    }

    /// What a change of the untouched pad is. If it is a touch of an unexpected sign, that sign is expected from now on.
    pub(super) fn judge_onset(&mut self, frame: &Frame) -> Judged {
        let noise = self.noise().0;
        let is_untouched = self.tracker.down().is_empty() && self.sign.has_both;
        let Some(locator) = self
            .locator
            .as_mut()
            .filter(|locator| is_untouched && locator.knows_both_signs())
        else {
            return Judged::Unclear;
        };
        let (as_touches, as_lift, is_clear) = match locator.explain_onset(&self.changes, noise) {
            Onset::Unclear => return Judged::Unclear,
            Onset::Expected => return Judged::Touch,
            Onset::Opposite {
                as_touches,
                as_lift,
                is_clear,
            } => (as_touches, as_lift, is_clear),
        };
        // A faint first touch does not show its sign.
        if !is_clear && !self.sign.is_known {
            return Judged::Touch;
        }
        let is_early = frame.t_ns.saturating_sub(self.first_ns) < EARLY_NS;
        let factor = if is_early { EARLY } else { 1.0 / EARLY };
        if self.sign.is_known || as_touches * factor >= as_lift {
            return Judged::Lift;
        }
        self.sign.expected = self.sign.expected.opposite();
        locator.expect_sign(self.sign.expected);
        self.sign.tried = Some(Tried::Touch {
            since_ns: frame.t_ns,
            frames: VecDeque::new(),
        });
        Judged::Touch
    }

    /// Whether touches of either sign are located.
    pub(super) fn knows_both_signs(&self) -> bool {
        self.sign.has_both
    }

    /// Remembers the reference that is given up because a finger seems to have been lying on the pad, which is untouched in this
    /// frame.
    pub(super) fn remember_reference(&mut self, frame: &Frame) {
        if !self.sign.is_known && self.knows_both_signs() && self.sign.tried.is_none() {
            self.sign.tried = Some(Tried::Lift {
                old: Box::new(self.reference.clone()),
                lifted: frame.volts.clone(),
                otherwise: self.sign.expected.opposite(),
            });
        }
    }

    /// Whether the pad is back at the reference that was given up: what was taken for the lift of a finger was a touch. Then that
    /// reference counts again, and the sign of that touch if touches explain it.
    pub(super) fn is_back_at_old_reference(
        &mut self,
        frame: &Frame,
        changed: &mut Vec<Touch>,
    ) -> bool {
        let Some(Tried::Lift {
            old,
            lifted,
            otherwise,
        }) = &self.sign.tried
        else {
            return false;
        };
        // A short press is over before the new reference is complete.
        let new = self.reference.is_ready().then_some(&self.reference);
        let (mut from_old, mut from_new, mut count) = (0.0, 0.0, 0.0);
        for (channel, volt) in frame.volts.iter().enumerate() {
            if old.is_muted(channel) || new.is_some_and(|new| new.is_muted(channel)) {
                continue;
            }
            let [noise, doubt] = new.unwrap_or(old).variances(channel);
            let variance = noise + doubt;
            let off = |reference_volt: f64| {
                let change = f64::from(*volt) / reference_volt - 1.0;
                change * change / variance
            };
            from_old += off(old.volts()[channel]);
            from_new += off(new.map_or(f64::from(lifted[channel]), |new| new.volts()[channel]));
            count += 1.0;
        }
        if from_old > BACK_VARIANCES * count || from_old > BACK_SHARE * from_new {
            return false;
        }
        let (old, lifted, sign) = (old.as_ref().clone(), lifted.clone(), *otherwise);
        self.lift_all(changed);
        self.reset();
        self.reference = old;
        self.reference.advance(frame.t_ns);
        self.reference.relative_changes(&lifted, &mut self.changes);
        let noise = self.noise().0;
        let is_touch = |locator: &Locator| {
            locator.rest_as_sign(sign, &self.changes, noise) < CONTRADICTED_REST
        };
        match self.locator.as_ref().is_none_or(is_touch) {
            true => self.sign.decide(sign),
            // Neither a lift nor a touch, such as frames that the board damaged: the sign stays open.
            false => self.sign.tried = None,
        }
        self.reference
            .relative_changes(&frame.volts, &mut self.changes);
        if let Some(locator) = &mut self.locator {
            locator.expect_sign(self.sign.expected);
        }
        true
    }

    /// Learns the sign from a frame that touches explain up to `rest` times noise and model error, and before which `were_down`
    /// touches were down. Returns whether a touch of unexpected sign stays too long to be one: then the reference is taken again.
    pub(super) fn learn_sign(
        &mut self,
        were_down: usize,
        rest: f64,
        frame: &Frame,
        changed: &mut Vec<Touch>,
    ) -> bool {
        let down = self.tracker.down().len();
        if down < were_down && rest < CONTRADICTED_REST {
            self.sign.decide(self.sign.expected);
        }
        let Some(Tried::Touch { since_ns, frames }) = &mut self.sign.tried else {
            return false;
        };
        if frame.t_ns.saturating_sub(*since_ns) > LONGEST_FIRST_NS {
            self.take_for_lift(changed);
            return true;
        }
        if frames.len() >= REFERENCE_FRAMES {
            frames.pop_front();
        }
        frames.push_back((frame.t_ns, frame.volts.clone()));
        false
    }

    /// Whether a frame that leaves `rest` times noise and model error contradicts a touch of unexpected sign: another one began
    /// beside it that has the first sign. Then it was none, and the reference is taken from the frames before.
    pub(super) fn is_contradicted(&mut self, rest: f64, changed: &mut Vec<Touch>) -> bool {
        let is_tried = matches!(
            &self.sign.tried,
            Some(Tried::Touch { frames, .. }) if frames.len() >= REFERENCE_FRAMES
        );
        if is_tried && rest > CONTRADICTED_REST {
            self.take_for_lift(changed);
            return true;
        }
        false
    }

    /// Whether a frame that touches explain up to `rest` times noise and model error is the untouched pad instead, because the
    /// reference was taken under fingers that have moved and lifted since. Then the reference is taken again.
    pub(super) fn is_lift_after_all(
        &mut self,
        locator: &Locator,
        rest: f64,
        frame: &Frame,
        changed: &mut Vec<Touch>,
    ) -> bool {
        let is_questioned = !self.sign.is_known
            && self.sign.has_both
            && !self.is_between
            && rest > QUESTIONED_REST
            && !self.tracker.down().is_empty()
            && self.frames.is_multiple_of(QUESTIONED_FRAMES);
        if !is_questioned {
            return false;
        }
        let noise = self.noise().0;
        let lift = locator.explain_lift(&self.changes, noise);
        // The present touches may fit poorly where others would fit well.
        if lift.rest > LIFT_SHARE * rest
            || lift.rest > LIFT_SHARE * locator.rest_as_touches(&self.changes, noise, &lift)
        {
            return false;
        }
        self.tracker.lift_all(changed);
        // If the touches were some after all, such as one very wide finger, the pad returns to this reference.
        let tried = Tried::Lift {
            old: Box::new(self.reference.clone()),
            lifted: frame.volts.clone(),
            otherwise: self.sign.expected,
        };
        // The locator follows with the next frame.
        self.sign.expected = lift.sign;
        self.sign.tried = Some(tried);
        self.retake_reference(&[(frame.t_ns, frame.volts.clone())]);
        true
    }

    /// What was taken for a touch of unexpected sign was the lift of a finger: its last frames are the untouched pad.
    fn take_for_lift(&mut self, changed: &mut Vec<Touch>) {
        let Some(Tried::Touch { frames, .. }) = self.sign.tried.take() else {
            return;
        };
        let frames: Vec<(Nanos, Vec<f32>)> = frames.into();
        self.tracker.lift_all(changed);
        // The locator follows with the next frame.
        self.sign.decide(self.sign.expected.opposite());
        self.retake_reference(&frames);
    }
}
