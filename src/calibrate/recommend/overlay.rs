//! Recommended settings, and their text.

use std::fmt::Write as _;

use super::trial::{PressLength, PressTrial};
use crate::profile::{Mode, Profile};
use crate::stats::quantile;
use crate::types::{NANOS_PER_MS, Nanos, Phase, ms_from_nanos};

/// The recommended settings, and the presses that determine each; listed in docs/calibration.md.
pub const SETTINGS: &[(&str, &str)] = &[
    ("long_ms", "length of short and of long presses"),
    (
        "classify",
        "short presses that take longer than a long press of the game",
    ),
    (
        "tremor_ms, tremor_mm",
        "re-touches: how soon, and how far away",
    ),
    ("slow_keys_ms", "brushes that are shorter than any press"),
    ("bounce_keys_ms", "re-touches after a press"),
    (
        "tapping_term_ms, hold_ms",
        "as long_ms, for profiles that distinguish taps from holds",
    ),
    ("double_tap_ms", "gaps between two presses"),
    ("force_min, force_max", "force of all presses"),
];

/// Quantiles of the greatest force of each press that give the lower and upper limit, and the factor on the lower one.
const FORCE_QUANTILES: [f64; 2] = [0.1, 0.8];
const NONE_SHARE: f64 = 0.5;
/// Least width of the force range.
const LEAST_RANGE: f64 = 0.05;
/// The time of a double tap: this quantile of the gaps times this margin, at least the default.
const GAP_QUANTILE: f64 = 0.9;
const GAP_MARGIN: f64 = 1.3;
const DOUBLE_TAP_MS: f64 = 300.0;
/// Least time of a hold: the default.
const HOLD_MS: u32 = 400;

/// How many requested presses came out right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TrialScore {
    /// Requested presses.
    pub requested: usize,
    /// Requests that came out right: the right output, as often and as long as requested, and no other output.
    pub right: usize,
    /// Presses that were not requested.
    pub wrong: usize,
}

impl TrialScore {
    /// Share of right requests, 0 to 1.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.right as f64 / self.requested.max(1) as f64
    }

    /// What the presses are worth, in right ones.
    pub(super) fn value(&self) -> f64 {
        self.right as f64 - WRONG_COST * self.wrong as f64
    }
}

impl std::ops::AddAssign for TrialScore {
    fn add_assign(&mut self, other: Self) {
        self.requested += other.requested;
        self.right += other.right;
        self.wrong += other.wrong;
    }
}

/// Cost of an unintended press, in right ones.
const WRONG_COST: f64 = 2.0;

/// Settings applied over a profile.
#[derive(Clone, Debug, PartialEq)]
pub struct RecommendedSettings {
    /// Least duration of a long press.
    pub long_ms: u32,
    /// Whether a press is sent only when it is known to be short or long.
    pub when_decided: bool,
    /// A finger that returns within this time has not lifted.
    pub tremor_ms: u32,
    /// Largest distance of such a return.
    pub tremor_mm: u32,
    /// A touch counts after this time (slow keys).
    pub slow_keys_ms: u32,
    /// A new press within this time is ignored (bounce keys).
    pub bounce_keys_ms: u32,
    /// Longest gap in a double tap.
    pub double_tap_ms: Option<u32>,
    /// Forces that count as 0 and as 1.
    pub force_range: Option<[f64; 2]>,
}

impl RecommendedSettings {
    /// The settings of a profile.
    #[must_use]
    pub fn from_profile(profile: &Profile) -> Self {
        let settings = &profile.settings;
        let ms = |ns: Nanos| (ns / NANOS_PER_MS) as u32;
        let latch = profile
            .bindings
            .iter()
            .find_map(|binding| match binding.mode {
                Mode::Classified(latch) => Some(latch),
                _ => None,
            });
        Self {
            long_ms: latch.map_or(200, |latch| ms(latch.long_after_ns)),
            when_decided: latch.is_some_and(|latch| latch.when_decided),
            tremor_ms: ms(settings.tremor_ns),
            tremor_mm: libm::round(settings.tremor_mm) as u32,
            slow_keys_ms: ms(settings.slow_keys_ns),
            bounce_keys_ms: ms(settings.bounce_keys_ns),
            double_tap_ms: None,
            force_range: None,
        }
    }

    /// Identifies settings during the search.
    pub(super) fn search_key(&self) -> [u32; 6] {
        [
            self.long_ms,
            u32::from(self.when_decided),
            self.tremor_ms,
            self.tremor_mm,
            self.slow_keys_ms,
            self.bounce_keys_ms,
        ]
    }

    /// Sets the ranges that follow from the presses directly: force, and the gap of double taps.
    pub(super) fn learn_ranges(&mut self, trials: &[PressTrial]) {
        let asked = trials.iter().filter(|trial| trial.request.is_some());
        let mut forces = Vec::new();
        let mut gaps_ms = Vec::new();
        for trial in asked {
            let hardest = trial.touches.iter().map(|(_, touch)| touch.contact.force);
            forces.extend(hardest.max_by(f64::total_cmp));
            gaps_ms.extend(double_gap_ms(trial, self.tremor_ms));
        }
        self.force_range = range(&forces);
        self.double_tap_ms = quantile(gaps_ms.iter().copied(), GAP_QUANTILE)
            .map(|gap_ms| (GAP_MARGIN * gap_ms).max(DOUBLE_TAP_MS))
            .filter(|ms| *ms > DOUBLE_TAP_MS)
            .map(|ms| libm::ceil(ms / 50.0) as u32 * 50);
    }

    /// The text of user settings; `scores` without and with them are given in a comment.
    #[must_use]
    pub fn toml(&self, scores: Option<(&TrialScore, &TrialScore)>) -> String {
        let mut text = String::new();
        if let Some((before, after)) = scores {
            let _ = writeln!(
                text,
                "# Recommended from {} presses: {} are right with these settings, {} without; {} unintended presses, \
                 {} without.",
                after.requested, after.right, before.right, after.wrong, before.wrong
            );
        }
        let _ = writeln!(text, "long_ms = {}", self.long_ms);
        let classify = if self.when_decided { "decided" } else { "down" };
        let _ = writeln!(text, "classify = \"{classify}\"");
        let _ = writeln!(text, "tapping_term_ms = {}", self.long_ms);
        let _ = writeln!(text, "hold_ms = {}", self.long_ms.max(HOLD_MS));
        for (key, value) in [
            ("tremor_ms", self.tremor_ms),
            ("tremor_mm", self.tremor_mm),
            ("slow_keys_ms", self.slow_keys_ms),
            ("bounce_keys_ms", self.bounce_keys_ms),
        ] {
            let _ = writeln!(text, "{key} = {value}");
        }
        if let Some(ms) = self.double_tap_ms {
            let _ = writeln!(text, "double_tap_ms = {ms}");
        }
        if let Some([least, most]) = self.force_range {
            let _ = writeln!(text, "force_min = {least:.2}\nforce_max = {most:.2}");
        }
        text
    }
}

/// The gap between the presses of a trial that requested two: the longest time without a touch.
fn double_gap_ms(trial: &PressTrial, joined_ms: u32) -> Option<f64> {
    let asked = trial.request.as_ref()?;
    if asked.length != PressLength::Twice {
        return None;
    }
    let mut down = 0usize;
    let mut lifted: Option<Nanos> = None;
    let mut longest: Option<Nanos> = None;
    for (t_ns, touch) in &trial.touches {
        match touch.phase {
            Phase::Down => {
                if let Some(since) = lifted.take() {
                    longest = longest.max(Some(t_ns - since));
                }
                down += 1;
            }
            Phase::Up => {
                down = down.saturating_sub(1);
                lifted = (down == 0).then_some(*t_ns);
            }
            Phase::Move => {}
        }
    }
    longest
        .map(ms_from_nanos)
        .filter(|ms| *ms > f64::from(joined_ms))
}

fn range(forces: &[f64]) -> Option<[f64; 2]> {
    let least = NONE_SHARE * quantile(forces.iter().copied(), FORCE_QUANTILES[0])?;
    let most = quantile(forces.iter().copied(), FORCE_QUANTILES[1])?;
    (most - least >= LEAST_RANGE).then(|| [least, most].map(|force| force.clamp(0.0, 1.0)))
}
