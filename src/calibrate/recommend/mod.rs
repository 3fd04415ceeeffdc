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
    /// Whether the presses come out worse with the settings than with the profile as it is: it is better kept. An unintended
    /// press counts as much as two right ones. Settings with which as many come out right suit the person's pace and force.
    #[must_use]
    pub fn is_worse(&self) -> bool {
        self.after.value() < self.before.value()
    }

    /// Whether some presses came out wrong, and as many would with the settings.
    #[must_use]
    pub fn helps_nothing(&self) -> bool {
        let is_flawless = self.before.right == self.before.requested && self.before.wrong == 0;
        !is_flawless && self.after == self.before
    }

    /// The text of `users/NAME.toml`.
    #[must_use]
    pub fn toml(&self) -> String {
        self.overlay.toml(Some((&self.before, &self.after)))
    }
}

/// Recommends settings for a profile on a pad of the given size. The best ones may still be worse than the profile as it is
/// ([`Recommendation::is_worse`]): they tie `tapping_term_ms` and `hold_ms` to `long_ms`, which a profile may set apart.
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
    let with_ranges = |settings: &RecommendedSettings| {
        let mut ranged = settings.clone();
        ranged.learn_ranges(trials);
        ranged
    };
    // The search weighs delays and other paces, and the ranges are learned after it: both may cost presses as they were made.
    let candidates = [
        with_ranges(&plain),
        searched.clone(),
        with_ranges(&searched),
    ];
    let mut after = judge.score(trials, Some(&plain))?;
    let mut overlay = plain;
    for candidate in candidates {
        let score = judge.score(trials, Some(&candidate))?;
        if score.value() >= after.value() {
            (overlay, after) = (candidate, score);
        }
    }
    Ok(Recommendation {
        overlay,
        before,
        after,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::find_shipped;

    fn score(right: usize, wrong: usize) -> TrialScore {
        TrialScore {
            requested: 24,
            right,
            wrong,
        }
    }

    #[test]
    fn fewer_unintended_presses_are_better_than_a_few_right_ones() {
        let plain = find_shipped("super-mario").expect("shipped");
        let plain = crate::profile::Profile::from_toml(&plain.name, &plain.toml).expect("sound");
        let found = |before, after| Recommendation {
            overlay: RecommendedSettings::from_profile(&plain),
            before,
            after,
        };
        assert!(!found(score(20, 6), score(19, 0)).is_worse());
        assert!(found(score(20, 0), score(21, 1)).is_worse());
        assert!(!found(score(20, 0), score(20, 0)).is_worse());
    }
}
