//! The pad as found, corrected by presses at known places as `gelpad calibrate` does.

use super::built::BuiltPad;
use crate::calibrate::{ModelPrediction, Press, Presses, fit_correction};
use crate::study::StudyError;
use crate::study::accuracy::draws::Draws;
use crate::study::accuracy::noise::Instrument;
use crate::study::accuracy::sensing::RestedDetector;
use crate::touch::Correction;
use crate::types::Contact;

/// Presses of a calibration: two minutes of a person's time.
pub(super) const PRESSES: usize = 30;
/// Frames that a press is averaged over.
const PRESS_FRAMES: usize = 10;
/// Presses that the sensing misses are repeated elsewhere, as a person would; at most this many in all.
const MOST_PRESSES: usize = 4 * PRESSES;

/// A correction, and the readings at rest that changes are relative to.
pub(super) struct Corrected {
    correction: Correction,
    rest: Vec<f64>,
}

impl Corrected {
    /// Presses the pad and learns how far its places are off.
    pub(super) fn learn(
        built: &BuiltPad,
        instrument: &Instrument,
        rest: &[f64],
        detector: &RestedDetector,
        mut draws: Draws,
    ) -> Result<Self, StudyError> {
        let mut list = Vec::with_capacity(PRESSES);
        for _ in 0..MOST_PRESSES {
            let pressed = draws.presses(1)?;
            let (volts, _) = built.specimen.pressed(&built.pad, &pressed)?;
            let frames = instrument.frames(&volts, draws.seed(), PRESS_FRAMES);
            let means = super::channel_means(&frames);
            let means: Vec<f32> = means.into_iter().map(|volt| volt as f32).collect();
            let [contact] = detector.contacts(&means)[..] else {
                continue;
            };
            list.push(Press {
                place_mm: pressed[0].centre_mm,
                modelled: Some(ModelPrediction {
                    force: contact.force,
                    place_mm: contact.centre_mm,
                }),
                changes: relative(&means, rest).map(f64::from).collect(),
            });
            if list.len() == PRESSES {
                break;
            }
        }
        let refused = |error: &dyn std::fmt::Display| StudyError::refused(error.to_string());
        let presses = Presses::new("the presses", list).map_err(|error| refused(&error))?;
        let fitted = fit_correction(&presses, built.pad.outline.size_mm());
        Ok(Self {
            correction: fitted.map_err(|error| refused(&error))?.correction,
            rest: rest.to_vec(),
        })
    }

    /// The contacts of a frame at their corrected places.
    pub(super) fn contacts(&mut self, volts: &[f32], contacts: &[Contact]) -> Vec<Contact> {
        let changes: Vec<f32> = relative(volts, &self.rest).collect();
        let mut corrected = contacts.to_vec();
        self.correction.apply(&changes, &mut corrected);
        corrected
    }
}

/// Relative changes from the readings at rest.
fn relative(volts: &[f32], rest: &[f64]) -> impl Iterator<Item = f32> {
    let pairs = volts.iter().zip(rest);
    pairs.map(|(volt, rest)| (f64::from(*volt) / rest - 1.0) as f32)
}
