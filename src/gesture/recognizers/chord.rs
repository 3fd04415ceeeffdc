//! A chord: every place of the binding is touched, and the touches began soon after each other. It stays down while every
//! place is touched.

use super::recognizer::{Playing, Recognizer, TouchGroup};
use crate::gesture::driver::TargetSet;
use crate::gesture::fingers::TouchSample;
use crate::profile::Chord;

#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) struct ChordRecognizer;

impl Recognizer for ChordRecognizer {
    type Gesture = Chord;

    fn is_group(_own: &Chord) -> bool {
        true
    }

    fn is_complete(own: &Chord, group: &TouchGroup<'_>) -> bool {
        let spread_ns = group.fingers.spread(group.places);
        spread_ns.is_some_and(|spread_ns| group.is_played || spread_ns < own.window_ns)
    }

    fn down(_own: &Chord, _touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self {
        playing.press(TargetSet::Main);
        Self
    }
}
