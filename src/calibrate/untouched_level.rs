//! What the pad reads just before a press: the level against which the press's changes are taken. Pure.
//!
//! A detector's own reference follows the pad while it is touched, by what the touches leave unexplained. On a pad that differs from
//! its drawing that is some percent of the press itself: too much for what is learned from presses.

use std::collections::VecDeque;

/// Frames that are averaged.
const LEVEL_FRAMES: usize = 40;
/// The last frames before a touch is seen are left out: the finger is already landing.
const LANDING_FRAMES: usize = 3;
/// So are the first frames after a touch: the finger is leaving.
const LEAVING_FRAMES: usize = 5;

/// Follows the readings of the untouched pad.
#[derive(Clone, Debug, Default)]
pub struct UntouchedLevel {
    recent: VecDeque<Vec<f32>>,
    /// Frames since the last touch.
    untouched: usize,
    /// Mean of the frames before the touch; empty if there were too few.
    volts: Vec<f64>,
}

impl UntouchedLevel {
    /// Takes a frame. `changes` are the detector's: 0 for a channel that is not used. `volts` are none if the board sends them in another
    /// order than the pad's: it was plugged in again, turned.
    ///
    /// Returns the relative changes against the level before the touch; those of the detector if the pad was not left
    /// alone before it.
    pub fn take_frame(
        &mut self,
        is_touched: bool,
        volts: Option<&[f32]>,
        changes: &[f32],
    ) -> Vec<f64> {
        let Some(volts) = volts else {
            *self = Self::default();
            return changes.iter().copied().map(f64::from).collect();
        };
        if is_touched {
            if self.untouched > 0 {
                self.measure();
            }
            self.untouched = 0;
        } else {
            self.untouched += 1;
            if self.is_untouched() {
                self.recent.push_back(volts.to_vec());
            }
            if self.recent.len() > LEVEL_FRAMES + LANDING_FRAMES {
                self.recent.pop_front();
            }
        }
        let of_channel = |(channel, change): (usize, &f32)| match self.volts.get(channel) {
            Some(level) if *change != 0.0 && *level != 0.0 => {
                f64::from(volts[channel]) / level - 1.0
            }
            _ => f64::from(*change),
        };
        changes.iter().enumerate().map(of_channel).collect()
    }

    /// Whether the frame last taken is one of the untouched pad, and no finger has just left it.
    #[must_use]
    pub fn is_untouched(&self) -> bool {
        self.untouched > LEAVING_FRAMES
    }

    /// Takes the mean of the recent frames.
    fn measure(&mut self) {
        let count = self.recent.len().saturating_sub(LANDING_FRAMES);
        let channels = match self.recent.front() {
            Some(first) if count > 0 => first.len(),
            _ => 0,
        };
        let mut sums = vec![0.0; channels];
        for frame in self.recent.iter().take(count) {
            for (sum, volt) in sums.iter_mut().zip(frame) {
                *sum += f64::from(*volt);
            }
        }
        self.volts = sums.iter().map(|sum| sum / count as f64).collect();
        self.recent.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_against_the_frames_before_the_touch() {
        let mut level = UntouchedLevel::default();
        let frame = |level: &mut UntouchedLevel, is_touched, volt: f32| {
            level.take_frame(is_touched, Some(&[volt, 5.0]), &[0.5, 0.0])
        };
        assert_eq!(frame(&mut level, true, 2.0), [0.5, 0.0], "no level yet");
        for _ in 0..20 {
            frame(&mut level, false, 2.0);
        }
        assert!(level.is_untouched());
        for _ in 0..LANDING_FRAMES {
            frame(&mut level, false, 9.0);
        }
        // The second channel is not used.
        assert_eq!(frame(&mut level, true, 3.0), [0.5, 0.0]);
        assert!(!level.is_untouched());
        assert_eq!(frame(&mut level, true, 4.0), [1.0, 0.0]);
        for _ in 0..LEAVING_FRAMES {
            frame(&mut level, false, 9.0);
        }
        assert_eq!(
            frame(&mut level, true, 7.0),
            [0.5, 0.0],
            "too short a pause"
        );
        for _ in 0..20 {
            frame(&mut level, false, 4.0);
        }
        // Frames of the leaving finger were not kept.
        assert_eq!(frame(&mut level, true, 3.0), [-0.25, 0.0]);
        // A board that was turned.
        assert_eq!(level.take_frame(true, None, &[0.5, 0.0]), [0.5, 0.0]);
        assert!(!level.is_untouched());
    }
}
