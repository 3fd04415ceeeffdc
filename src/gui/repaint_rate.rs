//! How often the window repaints while a game plays: often while a finger moves, seldom while nothing happens. Pure.

use std::time::Duration;

use crate::runtime::View;
use crate::types::Touch;

/// While a finger moves, comes or goes.
const MOVING: Duration = Duration::from_millis(16);
/// While a finger rests.
const HOLDING: Duration = Duration::from_millis(33);
/// While nothing touches the pad: noise and drift change slowly.
const RESTING: Duration = Duration::from_millis(100);
/// While the window is minimised: only messages are polled.
const HIDDEN: Duration = Duration::from_millis(1000);
/// A finger that moved by this much moves, mm.
const MOVED_MM: f64 = 0.4;
/// A finger counts as moving for this long after it did, s.
const SETTLES_S: f64 = 0.25;

/// Follows the touches of the newest views.
#[derive(Debug, Default)]
pub struct RepaintRate {
    /// The touches when one moved last.
    before: Vec<Touch>,
    moved_at_s: f64,
}

impl RepaintRate {
    /// The shortest time to the next repaint.
    pub fn interval(&mut self, view: &View, now_s: f64, is_hidden: bool) -> Duration {
        if is_hidden {
            return HIDDEN;
        }
        if self.has_moved(&view.touches) {
            self.before.clone_from(&view.touches);
            self.moved_at_s = now_s;
        }
        if now_s - self.moved_at_s < SETTLES_S && self.moved_at_s > 0.0 {
            MOVING
        } else if view.touches.is_empty() {
            RESTING
        } else {
            HOLDING
        }
    }

    fn has_moved(&self, touches: &[Touch]) -> bool {
        let is_same = |(old, new): (&Touch, &Touch)| {
            let [dx, dy] = [0, 1].map(|i| new.contact.centre_mm[i] - old.contact.centre_mm[i]);
            old.id == new.id && dx.hypot(dy) < MOVED_MM
        };
        touches.len() != self.before.len() || !self.before.iter().zip(touches).all(is_same)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::still;

    #[test]
    fn a_moving_finger_repaints_often_and_a_pad_at_rest_seldom() {
        let mut rate = RepaintRate::default();
        let mut view = still::view();
        assert_eq!(rate.interval(&view, 1.0, false), RESTING);
        view.touches = vec![still::touch(1, [50.0, 50.0], 0.5)];
        assert_eq!(rate.interval(&view, 2.0, false), MOVING, "it comes");
        view.touches = vec![still::touch(1, [50.1, 50.0], 0.5)];
        assert_eq!(rate.interval(&view, 3.0, false), HOLDING, "noise");
        view.touches = vec![still::touch(1, [53.0, 50.0], 0.5)];
        assert_eq!(rate.interval(&view, 4.0, false), MOVING);
        view.touches.clear();
        assert_eq!(rate.interval(&view, 5.0, false), MOVING, "it goes");
        assert_eq!(rate.interval(&view, 6.0, false), RESTING);
        assert_eq!(rate.interval(&view, 7.0, true), HIDDEN);
    }
}
