//! The pad as play finds it from its readings at rest.

use super::solved;
use crate::eit::identify::{GOOD_MISFIT, identify, misfit, one_by_one, rest_medians};
use crate::pad::Pad;
use crate::study::StudyError;
use crate::touch::SensingBuilder;

/// Frames from which a pad is found: a second.
pub(super) const FOUND_FROM_FRAMES: usize = 100;

/// What touches are located with once a pad is identified from frames of its rest, without the channels that the sensing leaves out;
/// `None` where the pad stays in use as it is: because it explains the readings or was found before, because no pad explains them, or because
/// touches are located from images, which take no pad as found.
pub(super) fn find(
    pad: &Pad,
    drawn: &SensingBuilder,
    frames: &[Vec<f32>],
    left_out: &[usize],
) -> Result<Option<SensingBuilder>, StudyError> {
    if drawn.table().is_none() || !pad.deviations.is_none() {
        return Ok(None);
    }
    let (mut volts, mut deviations) = rest_medians(frames);
    for channel in left_out {
        volts[*channel] = f64::NAN;
        deviations[*channel] = f64::INFINITY;
    }
    if misfit(pad, &volts).is_ok_and(|as_drawn| as_drawn <= GOOD_MISFIT) {
        return Ok(None);
    }
    match identify(pad, &volts, &deviations, &one_by_one) {
        Ok(found) => solved::found_pad(&found.pad, drawn).map(Some),
        Err(_) => Ok(None),
    }
}
