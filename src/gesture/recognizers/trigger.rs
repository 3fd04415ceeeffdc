//! A trigger: force as an axis, 0..1.

use super::curve::response;
use super::recognizer::{Playing, Recognizer};
use crate::gesture::fingers::TouchSample;
use crate::profile::Trigger;

#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) struct TriggerRecognizer;

impl Recognizer for TriggerRecognizer {
    type Gesture = Trigger;
    const ONE_TOUCH: bool = true;

    fn down(own: &Trigger, touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self {
        Self.moved(own, touch, playing);
        Self
    }

    fn moved(&mut self, own: &Trigger, touch: &TouchSample, playing: &mut Playing<'_, '_>) {
        let value = response(&own.curve, touch.force) * own.gain;
        playing.set_axis(own.axis, value.clamp(0.0, 1.0) as f32);
    }

    fn up(&mut self, own: &Trigger, playing: &mut Playing<'_, '_>) {
        playing.set_axis(own.axis, 0.0);
    }
}
