//! A finger that lifted while its frame was being read.

use super::evidence::Evidence;

/// A finger has lifted if this share of its response, or more, is gone, ...
const GONE_SHARE: f64 = 0.6;
/// ... which explains so many squared deviations, ...
const LEAST_GAIN: f64 = 40.0;
/// ... in at least so many parts, ...
const LEAST_PARTS: usize = 2;
/// ... and leaves at most this many squared deviations a reading ...
const REST: f64 = 4.0;
/// ... and this share of what changed.
const REST_SHARE: f64 = 0.15;

/// The response of a finger that lifted, and how many parts ago.
pub(super) fn find(evidence: &Evidence) -> Option<(Vec<f32>, usize)> {
    let held = evidence.held_count();
    if held == 0 {
        return None;
    }
    let first = evidence.responses() - held;
    let gone = evidence.candidate(first..first + held, LEAST_PARTS, |amplitude| {
        amplitude < -GONE_SHARE
    })?;
    let rest = gone.energy - gone.gain;
    let is_clear =
        gone.gain > LEAST_GAIN && rest < REST * gone.readings as f64 + REST_SHARE * gone.energy;
    is_clear.then(|| (evidence.held(gone.response - first).to_vec(), gone.parts))
}
