//! A double tap: a tap, and a second touch soon after it in the same region. It is down with the second touch.
//!
//! ```text
//! touch    ____/~~\____/~~~~~~\____
//! output   ____________/~~~~~~\____
//!                 | gap |
//! ```

use super::recognizer::{Playing, Recognizer, TapMemory};
use super::tap::TapRecognizer;
use crate::gesture::driver::TargetSet;
use crate::gesture::fingers::TouchSample;
use crate::profile::DoubleTap;

/// The first touch or the second.
#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) enum DoubleTapRecognizer {
    First(TapRecognizer),
    Second,
}

impl Recognizer for DoubleTapRecognizer {
    type Gesture = DoubleTap;

    fn down(own: &DoubleTap, _touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self {
        let t_ns = playing.t_ns();
        if playing.taps.take(t_ns, own.gap_ns) == 0 {
            return Self::First(TapRecognizer::new(t_ns, own.within_ns, own.slop_mm));
        }
        playing.press(TargetSet::Main);
        Self::Second
    }

    fn moved(&mut self, _own: &DoubleTap, touch: &TouchSample, _playing: &mut Playing<'_, '_>) {
        if let Self::First(tap) = self {
            tap.has_moved(touch.moved_mm);
        }
    }

    fn up(&mut self, _own: &DoubleTap, playing: &mut Playing<'_, '_>) {
        let t_ns = playing.t_ns();
        if matches!(self, Self::First(tap) if tap.is_tap(t_ns)) {
            *playing.taps = TapMemory {
                count: 1,
                last_ns: Some(t_ns),
            };
        }
    }
}
