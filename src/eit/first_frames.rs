//! The frames that the first reference is made of.
//!
//! A board that wakes, or a loose plug, sends a frame that has nothing to do with the pad. One such frame must not become part of
//! the reference, so frames are kept only while they agree: a frame whose readings lie far from the channels' medians is dropped, and
//! another is waited for.

use super::REFERENCE_FRAMES;

/// A frame is dropped if the median of its relative deviations from the channels' medians exceeds this share ...
const FAR: f64 = 0.05;
/// ... and this many times the same figure of the typical frame.
const FAR_TIMES: f64 = 20.0;
/// After this many frames the last ones count, whether they agree or not: the pad is what it is.
const MOST_FRAMES: usize = 40;

/// Frames collected so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FirstFrames {
    frames: Vec<(u64, Vec<f32>)>,
    taken: usize,
}

impl FirstFrames {
    /// Takes a frame at a time (ns). Returns the frames of the reference once enough of them agree.
    pub fn push(&mut self, t_ns: u64, volts: &[f32]) -> Option<Vec<(u64, Vec<f32>)>> {
        self.taken += 1;
        if volts.iter().all(|volt| volt.is_finite()) {
            self.frames.push((t_ns, volts.to_vec()));
        }
        if self.frames.len() < REFERENCE_FRAMES {
            return None;
        }
        if self.taken >= MOST_FRAMES {
            return Some(std::mem::take(self).into_last());
        }
        self.drop_far();
        (self.frames.len() >= REFERENCE_FRAMES).then(|| std::mem::take(self).into_last())
    }

    fn into_last(mut self) -> Vec<(u64, Vec<f32>)> {
        let from = self.frames.len().saturating_sub(REFERENCE_FRAMES);
        self.frames.split_off(from)
    }

    /// Drops the frames that lie far from the channels' medians.
    fn drop_far(&mut self) {
        let channels = self.frames[0].1.len();
        let medians: Vec<f64> = (0..channels)
            .map(|channel| {
                median(
                    &mut self
                        .frames
                        .iter()
                        .map(|(_, volts)| f64::from(volts[channel]))
                        .collect::<Vec<_>>(),
                )
            })
            .collect();
        let distances: Vec<f64> = self
            .frames
            .iter()
            .map(|(_, volts)| {
                let mut off: Vec<f64> = volts
                    .iter()
                    .zip(&medians)
                    .filter(|(_, median)| **median != 0.0)
                    .map(|(volt, median)| (f64::from(*volt) / median - 1.0).abs())
                    .collect();
                median(&mut off)
            })
            .collect();
        let limit = FAR.max(FAR_TIMES * median(&mut distances.clone()));
        let mut index = 0;
        self.frames.retain(|_| {
            index += 1;
            distances[index - 1] <= limit
        });
    }
}

/// The middle value; 0 of none.
fn median(values: &mut [f64]) -> f64 {
    super::median(values).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(index: u64, factor: f32) -> (u64, Vec<f32>) {
        let wobble = (index as f32 * 1.3).sin() * 1e-3;
        (
            index,
            (1..=20)
                .map(|channel| channel as f32 * factor * (1.0 + wobble))
                .collect(),
        )
    }

    #[test]
    fn one_bad_frame_costs_itself() {
        for factor in [0.0, 0.3, 2.0, 3.0, -1.0, f32::NAN, f32::INFINITY] {
            let mut first = FirstFrames::default();
            let mut ready = None;
            for index in 0..11 {
                assert_eq!(ready, None, "not before ten good frames");
                let (t_ns, volts) = frame(index, if index == 1 { factor } else { 1.0 });
                ready = first.push(t_ns, &volts);
            }
            let kept = ready.expect("ten good frames");
            assert_eq!(kept.len(), REFERENCE_FRAMES);
            assert!(kept.iter().all(|(t_ns, _)| *t_ns != 1), "{factor}");
        }
    }

    #[test]
    fn frames_that_agree_are_taken_at_once() {
        let mut first = FirstFrames::default();
        let ready: Vec<bool> = (0..10)
            .map(|index| {
                let (t_ns, volts) = frame(index, 1.0);
                first.push(t_ns, &volts).is_some()
            })
            .collect();
        assert_eq!(ready.iter().position(|ready| *ready), Some(9));
    }

    #[test]
    fn frames_that_never_agree_are_taken_in_the_end() {
        let mut first = FirstFrames::default();
        let ready = (0..100).position(|index| {
            let (t_ns, volts) = frame(index, [1.0, 3.0, -2.0][index as usize % 3]);
            first.push(t_ns, &volts).is_some()
        });
        assert!(ready.is_some_and(|index| index < MOST_FRAMES), "{ready:?}");
    }
}
