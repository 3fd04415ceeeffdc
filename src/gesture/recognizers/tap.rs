//! A tap: lifted sooner than the tapping term, moved less than the slop.
//!
//! ```text
//! touch    ____/~~\__________/~~~~~~~~~~~\__
//! output   _______/\________________________
//!              |term |       |term |
//! ```

use super::recognizer::{Playing, Recognizer};
use crate::gesture::driver::TargetSet;
use crate::gesture::fingers::TouchSample;
use crate::profile::Tap;
use crate::types::Nanos;

/// A touch that may be a tap.
#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) struct TapRecognizer {
    until_ns: Nanos,
    slop_mm: f64,
    moved_too_far: bool,
}

impl TapRecognizer {
    pub(super) fn new(down_ns: Nanos, within_ns: Nanos, slop_mm: f64) -> Self {
        Self {
            until_ns: down_ns + within_ns,
            slop_mm,
            moved_too_far: false,
        }
    }

    /// The touch is this far from where it went down.
    pub(super) fn has_moved(&mut self, moved_mm: f64) {
        self.moved_too_far |= moved_mm >= self.slop_mm;
    }

    /// Whether a touch that lifts now was a tap.
    pub(super) fn is_tap(&self, t_ns: Nanos) -> bool {
        !self.moved_too_far && t_ns < self.until_ns
    }
}

impl Recognizer for TapRecognizer {
    type Gesture = Tap;

    fn down(own: &Tap, _touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self {
        Self::new(playing.t_ns(), own.within_ns, own.slop_mm)
    }

    fn moved(&mut self, _own: &Tap, touch: &TouchSample, _playing: &mut Playing<'_, '_>) {
        self.has_moved(touch.moved_mm);
    }

    fn up(&mut self, _own: &Tap, playing: &mut Playing<'_, '_>) {
        if self.is_tap(playing.t_ns()) {
            playing.press(TargetSet::Main);
        }
    }
}
