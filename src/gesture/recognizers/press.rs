//! A press: down from its first moment.

use super::recognizer::{Playing, Recognizer};
use crate::gesture::driver::TargetSet;
use crate::gesture::fingers::TouchSample;
use crate::profile::Press;

#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) struct PressRecognizer;

impl Recognizer for PressRecognizer {
    type Gesture = Press;

    fn down(_own: &Press, _touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self {
        playing.press(TargetSet::Main);
        Self
    }
}
