//! Turns frames into presses at shown places, for every kind of calibration. Pure: readings in, presses out.
//!
//! ```text
//! readings  ~~~~~~~~~/~~~~~~~~~~~~~~~~~\~~~~~~
//! frames    untouched | settling | mean |          a press is complete when the pad is released
//! ```
//!
//! The readings must be those of the model alone: contacts before any correction of places, relative changes before any
//! weighting of channels. A calibration that learned from corrected contacts would be added to the one already in use.

use super::presses::{ModelPrediction, Press};
use crate::types::{Contact, PointMm};

/// The first frames of a press are left out: the finger is still sinking in.
const SETTLE_FRAMES: usize = 5;
/// A press is one of several fingers if it has as many frames with more than one touch. In a frame in which a finger lands or leaves,
/// some drives are read with it and others without, which may look like a second one.
const SEVERAL_FRAMES: usize = 5;
/// Frames of a press that are averaged, where the model locates it.
pub const MEAN_FRAMES: usize = 15;

/// How the pad is touched in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Touching {
    /// Nothing touches the pad.
    Nothing,
    /// One touch; with the model's prediction, where the pad's model can locate it.
    One(Option<ModelPrediction>),
    /// More than one touch.
    Several,
}

impl Touching {
    /// From the number of touches that are down and the contacts before any correction.
    #[must_use]
    pub fn from_contacts(down: usize, contacts: &[Contact]) -> Self {
        match down {
            0 => Self::Nothing,
            1 => Self::One(contacts.first().map(|contact| ModelPrediction {
                force: contact.force,
                place_mm: contact.centre_mm,
            })),
            _ => Self::Several,
        }
    }
}

/// What a frame completed.
#[derive(Clone, Debug, PartialEq)]
pub enum RecordedPress {
    /// No press ended in this frame.
    Pending,
    /// A press that cannot be used, and why.
    Refused(&'static str),
    /// A press.
    Complete(Press),
}

/// Records one press after the other.
#[derive(Clone, Debug)]
pub struct PressRecorder {
    /// Frames that are averaged at most.
    most_frames: usize,
    /// Frames of the current press with one touch, settling included.
    frames: usize,
    averaged: usize,
    change_sums: Vec<f64>,
    /// Sums of force, x and y.
    prediction_sums: Option<[f64; 3]>,
    /// Frames with more than one touch, which are not averaged.
    several: usize,
}

impl Default for PressRecorder {
    fn default() -> Self {
        Self::averaging(MEAN_FRAMES)
    }
}

impl PressRecorder {
    /// A recorder that averages at most `most_frames` frames of each press.
    #[must_use]
    pub fn averaging(most_frames: usize) -> Self {
        Self {
            most_frames,
            frames: 0,
            averaged: 0,
            change_sums: Vec::new(),
            prediction_sums: None,
            several: 0,
        }
    }

    /// Takes a frame while `shown_mm` is shown: how the pad is touched, and each channel's relative change.
    pub fn take_frame(
        &mut self,
        touching: Touching,
        changes: impl IntoIterator<Item = f64>,
        shown_mm: PointMm,
    ) -> RecordedPress {
        let prediction = match touching {
            Touching::Nothing if self.frames + self.several == 0 => return RecordedPress::Pending,
            Touching::Nothing => {
                let most_frames = self.most_frames;
                return std::mem::replace(self, Self::averaging(most_frames)).finish(shown_mm);
            }
            Touching::One(prediction) => prediction,
            Touching::Several => {
                self.several += 1;
                return RecordedPress::Pending;
            }
        };
        self.frames += 1;
        if self.frames > SETTLE_FRAMES && self.averaged < self.most_frames {
            self.add(prediction, changes);
        }
        RecordedPress::Pending
    }

    fn add(&mut self, prediction: Option<ModelPrediction>, changes: impl IntoIterator<Item = f64>) {
        for (channel, change) in changes.into_iter().enumerate() {
            match self.change_sums.get_mut(channel) {
                Some(sum) => *sum += change,
                None => self.change_sums.push(change),
            }
        }
        if let Some(ModelPrediction { force, place_mm }) = prediction {
            let sums = self.prediction_sums.get_or_insert_default();
            for (sum, value) in sums.iter_mut().zip([force, place_mm[0], place_mm[1]]) {
                *sum += value;
            }
        }
        self.averaged += 1;
    }

    fn finish(self, place_mm: PointMm) -> RecordedPress {
        if self.several >= SEVERAL_FRAMES {
            return RecordedPress::Refused("several touches at once: press with one finger");
        }
        if self.averaged == 0 {
            return RecordedPress::Refused("too short: press a little longer");
        }
        let count = self.averaged as f64;
        RecordedPress::Complete(Press {
            place_mm,
            modelled: self.prediction_sums.map(|sums| ModelPrediction {
                force: sums[0] / count,
                place_mm: [sums[1] / count, sums[2] / count],
            }),
            changes: self.change_sums.iter().map(|sum| sum / count).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(frames: &[Touching]) -> Vec<RecordedPress> {
        let mut recorder = PressRecorder::default();
        frames
            .iter()
            .map(|touching| recorder.take_frame(*touching, [0.5, -0.25], [40.0, 50.0]))
            .filter(|recorded| *recorded != RecordedPress::Pending)
            .collect()
    }

    fn one(x_mm: f64) -> Touching {
        Touching::One(Some(ModelPrediction {
            force: 0.6,
            place_mm: [x_mm, 52.0],
        }))
    }

    #[test]
    fn a_press_is_complete_when_it_is_released() {
        let mut frames = vec![Touching::Nothing; 5];
        // The finger lands beside the place, then settles.
        frames.extend([one(20.0); SETTLE_FRAMES]);
        frames.extend([one(41.0); 20]);
        assert_eq!(record(&frames), []);
        frames.push(Touching::Nothing);
        let [RecordedPress::Complete(press)] = &record(&frames)[..] else {
            panic!("{:?}", record(&frames));
        };
        assert_eq!(press.place_mm, [40.0, 50.0]);
        let modelled = press.modelled.expect("located");
        assert!((modelled.place_mm[0] - 41.0).abs() < 1e-9);
        assert!((press.changes[1] + 0.25).abs() < 1e-9);
    }

    #[test]
    fn a_brush_and_two_fingers_are_refused() {
        let brush = [one(1.0), one(1.0), one(1.0), Touching::Nothing];
        let mut two = vec![one(1.0); 3];
        two.extend([Touching::Several; 20]);
        two.push(Touching::Nothing);
        for (frames, reason) in [(&brush[..], "too short"), (&two, "several")] {
            let [RecordedPress::Refused(why)] = record(frames)[..] else {
                panic!("{:?}", record(frames));
            };
            assert!(why.starts_with(reason));
        }
    }

    #[test]
    fn what_a_landing_and_a_leaving_finger_look_like_is_no_second_one() {
        let mut frames = vec![Touching::Several; 2];
        frames.extend([one(41.0); 20]);
        frames.extend([Touching::Several, Touching::Nothing]);
        let [RecordedPress::Complete(press)] = &record(&frames)[..] else {
            panic!("{:?}", record(&frames));
        };
        let modelled = press.modelled.expect("located");
        assert!((modelled.place_mm[0] - 41.0).abs() < 1e-9);
    }
}
