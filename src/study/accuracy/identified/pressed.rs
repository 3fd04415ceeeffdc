//! Presses at known places, from which a pad is found better than from its readings at rest alone.

use super::built::BuiltPad;
use crate::eit::identify::KnownPress;
use crate::study::StudyError;
use crate::study::accuracy::draws::Draws;
use crate::study::accuracy::noise::Instrument;
use crate::study::accuracy::sensing::RestedDetector;

/// Presses of a calibration: two minutes of a person's time.
pub(super) const PRESSES: usize = 30;
/// Frames that a press is averaged over.
pub(super) const PRESS_FRAMES: usize = 10;
/// Presses that the sensing misses are repeated elsewhere, as a person would; at most this many in all.
const MOST_PRESSES: usize = 4 * PRESSES;

/// Presses a pad at random places that are known.
pub(super) fn press(
    built: &BuiltPad,
    instrument: &Instrument,
    rest: &[f64],
    detector: &RestedDetector,
    mut draws: Draws,
) -> Result<Vec<KnownPress>, StudyError> {
    let mut list = Vec::with_capacity(PRESSES);
    for _ in 0..MOST_PRESSES {
        let pressed = draws.presses(1)?;
        let (volts, _) = built.specimen.pressed(&built.pad, &pressed)?;
        let frames = instrument.frames(&volts, draws.seed(), PRESS_FRAMES);
        let means = super::channel_means(&frames);
        let volts: Vec<f32> = means.iter().map(|volt| *volt as f32).collect();
        if detector.contacts(&volts).len() != 1 {
            continue;
        }
        let pairs = means.iter().zip(rest);
        list.push(KnownPress {
            place_mm: pressed[0].centre_mm,
            changes: pairs.map(|(volt, rest)| volt / rest - 1.0).collect(),
        });
        if list.len() == PRESSES {
            break;
        }
    }
    Ok(list)
}
