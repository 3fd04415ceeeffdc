//! The pad as play has found it by the first press: identified from a second of rest, as the board of the condition reads it.

use super::Condition;
use super::board::{Board, Sensed};
use crate::eit::identify::{GOOD_MISFIT, identify, misfit, one_by_one, rest_medians};
use crate::study::StudyError;
use crate::study::accuracy::{Bench, solved};
use crate::touch::SensingBuilder;

/// Frames before the second of which the pad is identified, so that a board that wakes up badly is awake, and those of this second.
const SETTLING_FRAMES: usize = 200;
const REST_FRAMES: usize = 100;

/// What touches are located with once the pad is identified; `None` where its drawing stays in use: because it explains the readings, or
/// because no pad does.
pub(super) fn find(
    bench: &Bench,
    condition: &Condition,
    rest: &[f64],
    seed: u64,
) -> Result<Option<SensingBuilder>, StudyError> {
    let mut board = Board::new(condition, rest, &bench.pad.protocol, seed);
    let drawn = bench.sensing.builder();
    let mut sensed = Sensed::new(bench.sensing.new_detector(), drawn);
    let mut frames = Vec::with_capacity(REST_FRAMES);
    for index in 0..SETTLING_FRAMES + REST_FRAMES {
        let frame = board.read(rest);
        sensed.process(&frame);
        if index >= SETTLING_FRAMES {
            frames.push(frame.volts);
        }
    }
    let (mut volts, mut deviations) = rest_medians(&frames);
    for channel in sensed.left_out() {
        volts[channel] = f64::NAN;
        deviations[channel] = f64::INFINITY;
    }
    if misfit(&bench.pad, &volts).is_ok_and(|as_drawn| as_drawn <= GOOD_MISFIT) {
        return Ok(None);
    }
    match identify(&bench.pad, &volts, &deviations, &one_by_one) {
        Ok(found) => solved::found_pad(&found.pad, drawn).map(Some),
        Err(_) => Ok(None),
    }
}
