//! A finger that lifted while its frame was being read.

use super::evidence::{Candidate, Evidence};

/// A lift explains so many squared deviations, ...
const LEAST_GAIN: f64 = 40.0;
/// ... and leaves at most this many a reading ...
const REST: f64 = 4.0;
/// ... and this share of what changed.
const REST_SHARE: f64 = 0.15;

/// A finger that moves has lifted if this share of its response, or more, is gone: a place that is a little wrong leaves up to 0.7 of that of
/// a small finger unseen. Of one that lifted while it moved, 0.87 to 1.13 are gone.
const GONE_SHARE_MOVING: f64 = 0.8;

/// The finger that lifted, and in how many parts its lift is seen.
pub(super) fn find(evidence: &Evidence, is_moving: bool) -> Option<Candidate> {
    let gone = evidence.lift()?;
    if is_moving && gone.amplitude > -GONE_SHARE_MOVING {
        return None;
    }
    let rest = gone.energy - gone.gain;
    let is_clear =
        gone.gain > LEAST_GAIN && rest < REST * gone.readings as f64 + REST_SHARE * gone.energy;
    is_clear.then_some(gone)
}
