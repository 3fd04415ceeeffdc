//! A palm or a forearm resting on the pad.
//!
//! Fitted as fingers it would be several strong ones, in places that change from frame to frame. So if a frame may show
//! one, the image decides, and the palm becomes one wide contact. After a moment the reference is taken again with the palm
//! on the pad, which can then be played beside it; when it leaves, the rebound takes the reference once more. A pad that was
//! learned from presses has no image that shows palms.

use super::Detector;
use crate::types::{Frame, NANOS_PER_MS, Nanos, Touch};

/// A frame may show a palm if located touches leave this many times noise and model error, ...
const POOR_REST: f64 = 4.0;
/// ... or there are this many touches, ...
const MANY_TOUCHES: usize = 5;
/// ... or this many of full force.
const HEAVY_TOUCHES: usize = 3;
/// Touches that leave less than this many times noise and model error are fingers.
const FINGERS_REST: f64 = 2.0;
/// A palm that rests for this long becomes part of the reference.
const REST_NS: Nanos = 300 * NANOS_PER_MS;
/// A palm that is not detected for this long has left.
const GONE_NS: Nanos = 100 * NANOS_PER_MS;

impl Detector {
    /// Whether a frame shows a palm. If so, the contacts of the image replace the located ones.
    pub(super) fn is_under_palm(&mut self, rest: f64, t_ns: Nanos) -> bool {
        // The image of a learned pad shows where a press is, not how large.
        let model = self.sensing.locator_model.as_ref();
        if model.is_some_and(|model| model.is_learned()) {
            return false;
        }
        // Where the table covers all fingers, what they explain this well is not a palm.
        let are_fingers = self.knows_both_signs() && rest < FINGERS_REST;
        let heavy = !are_fingers
            && self
                .contacts
                .iter()
                .filter(|contact| contact.force >= 1.0)
                .count()
                >= HEAVY_TOUCHES;
        let is_possible = heavy
            || rest > POOR_REST
            || (self.contacts.len() >= MANY_TOUCHES && !are_fingers)
            || self.palm_ns.is_some();
        if !is_possible {
            return false;
        }
        self.draw_image();
        let (doubt, down) = (self.reference.doubt(), self.tracker.down());
        let is_palm =
            self.by_image
                .replace_by_palm(&self.image, doubt, down, heavy, &mut self.contacts);
        if is_palm {
            let since = self.palm_ns.map_or(t_ns, |[since, _]| since);
            self.palm_ns = Some([since, t_ns]);
        } else if self
            .palm_ns
            .is_some_and(|[_, last]| t_ns.saturating_sub(last) > GONE_NS)
        {
            self.palm_ns = None;
        }
        is_palm
    }

    /// Reports the contacts of a palm, or retakes the reference when it has rested for a while.
    pub(super) fn handle_palm(&mut self, frame: &Frame, changed: &mut Vec<Touch>) {
        let rests = self
            .palm_ns
            .is_some_and(|[since, _]| frame.t_ns.saturating_sub(since) > REST_NS);
        if rests {
            self.tracker.lift_all(changed);
            self.retake_reference(&[(frame.t_ns, frame.volts.clone())]);
        } else {
            self.tracker.follow(frame.t_ns, &self.contacts, changed);
        }
    }
}
