//! The mean of what a held finger changes, over its frames.
//!
//! In much noise a single frame shows place and size of a finger poorly, and a mean of poor fits is poorer than a fit to the mean: the
//! response is not linear, and each fit leans towards a typical finger.

use super::metric::{Whitened, energy};
use crate::eit::response::TouchModel;

/// A mean is of at most this many frames, so that a press that grows harder is followed.
const MOST_FRAMES: u32 = 8;

/// What a touch that does not move has changed, whitened, and the touch that explains it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct HeldMean {
    mean: Whitened,
    frames: u32,
    touch: Option<TouchModel>,
}

impl HeldMean {
    /// Starts again: the finger has moved.
    pub(super) fn clear(&mut self) {
        self.frames = 0;
        self.touch = None;
    }

    /// Adds what the touch changed in a frame, `response`, and what no touch explains, `residual`.
    pub(super) fn add(&mut self, response: &[f32], residual: &[f32]) {
        self.frames = (self.frames + 1).min(MOST_FRAMES);
        let mean = &mut self.mean.coordinates;
        mean.resize(response.len(), 0.0);
        let weight = 1.0 / self.frames as f32;
        for ((mean, own), rest) in mean.iter_mut().zip(response).zip(residual) {
            *mean += weight * (own + rest - *mean);
        }
        self.mean.energy = energy(&self.mean.coordinates);
    }

    /// Number of frames in the mean.
    pub(super) fn frames(&self) -> u32 {
        self.frames
    }

    /// The mean of what the touch changed.
    pub(super) fn mean(&self) -> &Whitened {
        &self.mean
    }

    /// Sets the touch that explains the mean.
    pub(super) fn set_touch(&mut self, touch: TouchModel) {
        self.touch = Some(touch);
    }

    /// The touch that explains the mean; none for a single frame.
    pub(super) fn touch(&self) -> Option<&TouchModel> {
        self.touch.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_count_alike_until_the_mean_is_long() {
        let mut held = HeldMean::default();
        held.add(&[1.0, 0.0], &[0.5, 0.5]);
        held.add(&[2.0, 0.0], &[0.5, -0.5]);
        assert_eq!(
            (held.frames(), held.mean.coordinates.as_slice()),
            (2, &[2.0, 0.0][..])
        );
        for _ in 0..100 {
            held.add(&[4.0, 0.0], &[0.0, 0.0]);
        }
        assert!(
            (held.mean.coordinates[0] - 4.0).abs() < 1e-4,
            "{:?}",
            held.mean
        );
        held.clear();
        held.add(&[7.0, 0.0], &[0.0, 0.0]);
        assert_eq!(
            (held.frames(), held.mean.coordinates.as_slice()),
            (1, &[7.0, 0.0][..])
        );
    }
}
