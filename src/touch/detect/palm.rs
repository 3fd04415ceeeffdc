//! A palm or a forearm that comes to lie on the pad.
//!
//! It is no finger: fitted as fingers it is several strong ones, or one too many, in places that change from frame to frame. So
//! as soon as it may be one the image is asked, and it is told as what it is, one wide contact. When it has lain for a
//! moment it goes into the reference: the pad is touched beside it as if it were not there, as if it had lain there from the
//! start; and when it leaves, the pad's rebound takes the reference anew.

use super::Detector;
use crate::types::{Frame, NANOS_PER_MS, Nanos, Touch};

/// Located touches that leave this many times what noise and the model's error explain may be a palm, ...
const POOR_REST: f64 = 4.0;
/// ... as may so many touches at once, ...
const MANY: usize = 5;
/// ... or so many of full force.
const HEAVY: usize = 3;
/// A palm that has lain for so long is taken into the reference.
const LIES_NS: Nanos = 300 * NANOS_PER_MS;
/// A palm that is not seen for so long has gone.
const GONE_NS: Nanos = 100 * NANOS_PER_MS;

impl Detector {
    /// Whether a frame whose touches were located is that of a palm; the contacts are then those of its image.
    pub(super) fn is_under_palm(&mut self, rest: f64, t_ns: Nanos) -> bool {
        let heavy = self
            .contacts
            .iter()
            .filter(|contact| contact.force >= 1.0)
            .count()
            >= HEAVY;
        let may_be =
            heavy || rest > POOR_REST || self.contacts.len() >= MANY || self.palm_ns.is_some();
        if !may_be {
            return false;
        }
        let (doubt, down) = (self.reference.doubt(), self.tracker.down());
        let is_seen = self
            .by_image
            .palm(&self.image, doubt, down, heavy, &mut self.contacts);
        if is_seen {
            let since = self.palm_ns.map_or(t_ns, |[since, _]| since);
            self.palm_ns = Some([since, t_ns]);
        } else if self
            .palm_ns
            .is_some_and(|[_, last]| t_ns.saturating_sub(last) > GONE_NS)
        {
            self.palm_ns = None;
        }
        is_seen
    }

    /// Tells a palm's contacts, and takes it into the reference when it has lain for a while.
    pub(super) fn bear_palm(&mut self, frame: &Frame, changed: &mut Vec<Touch>) {
        let lies = self
            .palm_ns
            .is_some_and(|[since, _]| frame.t_ns.saturating_sub(since) > LIES_NS);
        if lies {
            self.tracker.lift_all(changed);
            self.retaken += 1;
            self.start_anew(frame);
        } else {
            self.tracker.follow(frame.t_ns, &self.contacts, changed);
        }
    }
}
