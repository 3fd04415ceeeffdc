//! How often the window repaints while a game plays: often while a finger moves, seldom while nothing happens. Pure.

use std::time::Duration;

use crate::runtime::View;
use crate::types::Touch;

/// While a finger moves.
const MOVING: Duration = Duration::from_millis(16);
/// While a finger rests.
const HOLDING: Duration = Duration::from_millis(50);
/// Shortly after the last finger has lifted: its path fades.
const FADING: Duration = Duration::from_millis(100);
/// While nothing touches the pad: noise and drift change slowly, and a touch is shown at once (`waker.rs`).
const RESTING: Duration = Duration::from_millis(333);
/// While the window is minimised: only messages are polled, and nothing is shown earlier.
pub(super) const HIDDEN: Duration = Duration::from_millis(1000);
/// A finger that moved by this much moves, mm.
const MOVED_MM: f64 = 0.4;
/// A finger counts as moving for this long after it did, s.
const SETTLES_S: f64 = 0.1;
/// How long paths fade after the last finger has lifted, s.
const FADES_S: f64 = 0.8;

/// Follows the touches of the newest views.
#[derive(Debug, Default)]
pub struct RepaintRate {
    /// The touches when one moved, came or went last.
    before: Vec<Touch>,
    moved_at_s: Option<f64>,
    touched_at_s: Option<f64>,
}

impl RepaintRate {
    /// The shortest time to the next repaint.
    pub fn interval(&mut self, view: &View, now_s: f64, is_hidden: bool) -> Duration {
        if is_hidden {
            return HIDDEN;
        }
        let touches = &view.touches;
        let is_known = |new: &Touch| self.before.iter().any(|old| old.id == new.id);
        let has_moved = self.before.iter().any(|old| has_moved(old, touches));
        if has_moved {
            self.moved_at_s = Some(now_s);
        }
        if has_moved || touches.len() != self.before.len() || !touches.iter().all(is_known) {
            self.before.clone_from(touches);
        }
        if !touches.is_empty() {
            self.touched_at_s = Some(now_s);
        }
        let lately = |at_s: Option<f64>, for_s: f64| at_s.is_some_and(|at_s| now_s - at_s < for_s);
        if lately(self.moved_at_s, SETTLES_S) {
            MOVING
        } else if !touches.is_empty() {
            HOLDING
        } else if lately(self.touched_at_s, FADES_S) {
            FADING
        } else {
            RESTING
        }
    }
}

/// Whether a touch is no longer where it was.
fn has_moved(old: &Touch, touches: &[Touch]) -> bool {
    let new = touches.iter().find(|new| new.id == old.id);
    new.is_some_and(|new| {
        let [dx, dy] = [0, 1].map(|i| new.contact.centre_mm[i] - old.contact.centre_mm[i]);
        dx.hypot(dy) >= MOVED_MM
    })
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
        assert_eq!(rate.interval(&view, 2.0, false), HOLDING, "it comes");
        view.touches = vec![still::touch(1, [50.1, 50.0], 0.5)];
        assert_eq!(rate.interval(&view, 3.0, false), HOLDING, "noise");
        view.touches = vec![still::touch(1, [53.0, 50.0], 0.5)];
        assert_eq!(rate.interval(&view, 4.0, false), MOVING);
        assert_eq!(rate.interval(&view, 4.2, false), HOLDING, "it rests");
        view.touches.clear();
        assert_eq!(rate.interval(&view, 5.0, false), FADING, "it goes");
        assert_eq!(rate.interval(&view, 6.0, false), RESTING);
        assert_eq!(rate.interval(&view, 7.0, true), HIDDEN);
    }
}
