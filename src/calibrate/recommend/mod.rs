//! Settings for one person, recommended from that person's own presses.
//!
//! A person is asked to press shown regions, shortly, long, or twice. What the pad saw of it is kept as it was
//! ([`Trial`]). Then settings are tried on it: every candidate plays all presses through the real gestures, and the one
//! under which most are what was asked for is recommended ([`recommend`]). So nothing is guessed from averages, and what
//! the person is told ("38 of 40 right, 21 without") was counted.
//!
//! Delay is paid for: a setting that makes a press or a release later must be worth it (`search::cost`).
//! Each press is tried at several speeds, since nobody presses twice alike: a threshold that just misses the recorded
//! presses loses to one in the middle of the gap.

mod overlay;
mod search;
mod session;
mod trial;

pub use overlay::{Overlay, SETTINGS};
pub use search::climb;
pub use session::{QUIET_NS, Session};
pub use trial::{Asked, Judge, Length, Outcome, Trial};

use crate::profile::{FindBase, Source};
use crate::types::Faulty;

/// Fewer presses recommend nothing.
pub const FEWEST_TRIALS: usize = 12;

/// What is recommended, and what it would have made of the presses.
#[derive(Clone, Debug, PartialEq)]
pub struct Recommendation {
    /// The settings.
    pub overlay: Overlay,
    /// What the profile made of the presses as it is.
    pub before: Outcome,
    /// What it would have made of them.
    pub after: Outcome,
}

impl Recommendation {
    /// The text of `users/NAME.toml`.
    #[must_use]
    pub fn toml(&self) -> String {
        self.overlay.toml(Some((&self.before, &self.after)))
    }
}

/// Why nothing is recommended.
#[derive(Debug, thiserror::Error)]
pub enum RecommendError {
    /// Too few presses.
    #[error("{found} presses tell too little: at least {FEWEST_TRIALS} are needed")]
    TooFew {
        /// How many there are.
        found: usize,
    },
    /// The profile cannot be read.
    #[error("the profile cannot be played: {}", .0.name)]
    Profile(Faulty),
    /// A press was asked for that the profile does not know.
    #[error(
        "the profile has no region `{0}` that a press is bound to: ask for regions that it has"
    )]
    Region(String),
}

/// Recommends settings for the person who made the presses, on a pad of a size, for a profile.
///
/// # Errors
/// Too few presses; a profile that cannot be read; a region that it has not.
pub fn recommend(
    trials: &[Trial],
    profile: &Source,
    find: FindBase<'_>,
    pad_mm: [f64; 2],
) -> Result<Recommendation, RecommendError> {
    if trials.len() < FEWEST_TRIALS {
        return Err(RecommendError::TooFew {
            found: trials.len(),
        });
    }
    let judge = Judge::new(profile, find, pad_mm);
    let plain = Overlay::of_profile(&judge.profile(None)?);
    let before = judge.outcome(trials, None)?;
    let mut overlay = search::best(&judge, trials, plain)?;
    overlay.learn_ranges(trials);
    let after = judge.outcome(trials, Some(&overlay))?;
    Ok(Recommendation {
        overlay,
        before,
        after,
    })
}
