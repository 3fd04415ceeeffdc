//! A pointer: the mouse moves as the touch moves. Fractions of a pixel are kept for the next move.

use super::recognizer::{Playing, Recognizer};
use crate::gesture::fingers::TouchSample;
use crate::profile::Pointer;
use crate::types::{Action, PointMm};

/// A touch that moves the mouse.
#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) struct PointerRecognizer {
    at_mm: PointMm,
    /// Fractions of a pixel or of a notch.
    rest: PointMm,
}

impl Recognizer for PointerRecognizer {
    type Gesture = Pointer;
    const ONE_TOUCH: bool = true;

    fn down(_own: &Pointer, touch: &TouchSample, _playing: &mut Playing<'_, '_>) -> Self {
        Self {
            at_mm: touch.at_mm,
            rest: [0.0; 2],
        }
    }

    fn moved(&mut self, own: &Pointer, touch: &TouchSample, playing: &mut Playing<'_, '_>) {
        let [dx, dy] = [0, 1].map(|i| {
            self.rest[i] += (touch.at_mm[i] - self.at_mm[i]) * own.gain;
            let pixels = libm::trunc(self.rest[i]);
            self.rest[i] -= pixels;
            pixels as i32
        });
        self.at_mm = touch.at_mm;
        match (dx, dy) {
            (0, 0) => {}
            _ if own.wheel => playing.send(Action::Wheel { dx, dy }),
            // On screens y points down.
            _ => playing.send(Action::Motion { dx, dy: -dy }),
        }
    }
}
