//! Recommends settings for a person from that person's own presses.
//!
//! The person presses shown regions: short, long, or twice. The touches of each request are recorded as a [`PressTrial`]. Every
//! candidate plays all trials through the real gestures, and the settings with which most presses come out right are
//! recommended ([`recommend`]). So the figures that the person gets ("38 of 40 right, 21 without") are counted, not estimated.
//!
//! Delays have a cost: a setting that delays presses or releases must be worth it (`search::cost`). Each press is played at
//! several speeds, so a threshold that just misses the recorded presses scores less than one in the middle of the gap.

mod overlay;
mod scorer;
mod search;
mod session;
mod trial;

pub use overlay::{RecommendedSettings, SETTINGS, TrialScore};
pub use scorer::{FEWEST_TRIALS, RecommendError, TrialScorer};
pub use search::search_settings;
pub use session::{PressSession, QUIET_NS};
pub use trial::{PressLength, PressRequest, PressTrial};

use crate::profile::{FindBase, Source};

/// Recommended settings with their score.
#[derive(Clone, Debug, PartialEq)]
pub struct Recommendation {
    /// The settings.
    pub overlay: RecommendedSettings,
    /// Score of the profile as it is.
    pub before: TrialScore,
    /// Score with the settings.
    pub after: TrialScore,
}

impl Recommendation {
    /// The text of `users/NAME.toml`.
    #[must_use]
    pub fn toml(&self) -> String {
        self.overlay.toml(Some((&self.before, &self.after)))
    }
}

/// Recommends settings for a profile on a pad of the given size.
///
/// # Errors
/// Too few presses; a profile that cannot be read; a region that it does not have.
pub fn recommend(
    trials: &[PressTrial],
    profile: &Source,
    find: FindBase<'_>,
    pad_mm: [f64; 2],
) -> Result<Recommendation, RecommendError> {
    if trials.len() < FEWEST_TRIALS {
        return Err(RecommendError::TooFew {
            found: trials.len(),
        });
    }
    let judge = TrialScorer::new(profile, find, pad_mm);
    let plain = RecommendedSettings::from_profile(&judge.profile(None)?);
    let before = judge.score(trials, None)?;
    let searched = search::best(&judge, trials, plain.clone())?;
    let mut ranged = searched.clone();
    ranged.learn_ranges(trials);
    // The search weighs delays and other paces, and the ranges are learned after it: none of them may cost presses.
    let mut after = judge.score(trials, Some(&plain))?;
    let mut overlay = plain;
    for better in [searched, ranged] {
        let score = judge.score(trials, Some(&better))?;
        if score.value() >= after.value() {
            (overlay, after) = (better, score);
        }
    }
    Ok(Recommendation {
        overlay,
        before,
        after,
    })
}
