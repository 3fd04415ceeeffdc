//! A triple tap: two taps, and a third touch, soon after each other in the same region. It is down with the third touch.
//!
//! ```text
//! touch    ____/~~\____/~~\____/~~~~~~\____
//! output   ____________________/~~~~~~\____
//!                 |gap |  |gap |
//! ```

use super::recognizer::{Playing, Recognizer, TapMemory};
use super::tap::TapRecognizer;
use crate::gesture::driver::TargetSet;
use crate::gesture::fingers::TouchSample;
use crate::profile::TripleTap;

/// One of the first two touches, or the third.
#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) enum TripleTapRecognizer {
    Tap { tap: TapRecognizer, before: u32 },
    Third,
}

impl Recognizer for TripleTapRecognizer {
    type Gesture = TripleTap;

    fn down(own: &TripleTap, _touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self {
        let t_ns = playing.t_ns();
        let before = playing.taps.take(t_ns, own.gap_ns);
        if before < 2 {
            let tap = TapRecognizer::new(t_ns, own.within_ns, own.slop_mm);
            return Self::Tap { tap, before };
        }
        playing.press(TargetSet::Main);
        Self::Third
    }

    fn moved(&mut self, _own: &TripleTap, touch: &TouchSample, _playing: &mut Playing<'_, '_>) {
        if let Self::Tap { tap, .. } = self {
            tap.has_moved(touch.moved_mm);
        }
    }

    fn up(&mut self, _own: &TripleTap, playing: &mut Playing<'_, '_>) {
        let t_ns = playing.t_ns();
        if let Self::Tap { tap, before } = self
            && tap.is_tap(t_ns)
        {
            *playing.taps = TapMemory {
                count: *before + 1,
                last_ns: Some(t_ns),
            };
        }
    }
}
