//! A level of force, with hysteresis.

use super::recognizer::{Playing, Recognizer};
use crate::gesture::driver::TargetSet;
use crate::gesture::fingers::TouchSample;
use crate::profile::Force;

#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) struct ForceRecognizer {
    is_pressed: bool,
}

impl Recognizer for ForceRecognizer {
    type Gesture = Force;

    fn down(own: &Force, touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self {
        let mut recognizer = Self { is_pressed: false };
        recognizer.moved(own, touch, playing);
        recognizer
    }

    fn moved(&mut self, own: &Force, touch: &TouchSample, playing: &mut Playing<'_, '_>) {
        let was_pressed = self.is_pressed;
        let level = if was_pressed { own.release } else { own.press };
        self.is_pressed = touch.force >= level;
        match (was_pressed, self.is_pressed) {
            (false, true) => playing.press(TargetSet::Main),
            (true, false) => playing.release(),
            _ => {}
        }
    }
}
