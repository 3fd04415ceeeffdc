//! A finger that lifted while its frame was being read.

use super::evidence::{Candidate, Evidence};

/// A lift explains so many squared deviations, ...
const LEAST_GAIN: f64 = 40.0;
/// ... and leaves at most this many a reading ...
const REST: f64 = 4.0;
/// ... and this share of what changed.
const REST_SHARE: f64 = 0.15;

/// The finger that lifted, and in how many parts its lift is seen.
pub(super) fn find(evidence: &Evidence) -> Option<Candidate> {
    let gone = evidence.lift()?;
    let rest = gone.energy - gone.gain;
    let is_clear =
        gone.gain > LEAST_GAIN && rest < REST * gone.readings as f64 + REST_SHARE * gone.energy;
    is_clear.then_some(gone)
}
