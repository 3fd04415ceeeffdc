//! The settings that are recommended, and their text.

use std::fmt::Write as _;

use super::{Outcome, Trial};
use crate::profile::{Mode, Profile};
use crate::types::{NANOS_PER_MS, Nanos, Phase, ms_from_nanos};

/// Keys that are recommended, and by what presses: the guide lists them.
pub const SETTINGS: &[(&str, &str)] = &[
    ("long_ms", "length of short and of long presses"),
    (
        "classify",
        "short presses that take longer than a long press of the game",
    ),
    (
        "tremor_ms, tremor_mm",
        "re-touches: how soon, and how far off",
    ),
    ("slow_keys_ms", "brushes that are shorter than any press"),
    ("bounce_keys_ms", "re-touches behind a press"),
    (
        "tapping_term_ms, hold_ms",
        "as long_ms, for profiles that tell taps from holds",
    ),
    ("double_tap_ms", "gaps between two presses"),
    ("force_min, force_max", "force of all presses"),
];

/// Forces that count as none and as full, as quantiles of the hardest moment of each press, and how much lower "none" is.
const FORCE_QUANTILES: [f64; 2] = [0.1, 0.8];
const NONE_SHARE: f64 = 0.5;
/// A range of force is at least this wide.
const LEAST_RANGE: f64 = 0.05;
/// Gaps of double presses: this quantile, and so much more; never less than the usual time.
const GAP_QUANTILE: f64 = 0.9;
const GAP_MARGIN: f64 = 1.3;
const DOUBLE_TAP_MS: f64 = 300.0;
/// A hold is never shorter than usual.
const HOLD_MS: u32 = 400;

/// Settings over a profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// A touch that lasts this long is a long press.
    pub long_ms: u32,
    /// A press goes out when it is known to be short or long.
    pub when_decided: bool,
    /// A finger that comes back sooner has not lifted.
    pub tremor_ms: u32,
    /// It comes back nearer than this.
    pub tremor_mm: u32,
    /// A touch counts only after this time.
    pub slow_keys_ms: u32,
    /// A re-press sooner is ignored.
    pub bounce_keys_ms: u32,
    /// The second touch of a double tap comes sooner.
    pub double_tap_ms: Option<u32>,
    /// Forces that count as none and as full.
    pub force_range: Option<[f64; 2]>,
}

impl Overlay {
    /// What a profile has by itself.
    #[must_use]
    pub fn of_profile(profile: &Profile) -> Self {
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

    /// What settings are told apart by while they are searched.
    pub(super) fn key(&self) -> [u32; 6] {
        [
            self.long_ms,
            u32::from(self.when_decided),
            self.tremor_ms,
            self.tremor_mm,
            self.slow_keys_ms,
            self.bounce_keys_ms,
        ]
    }

    /// Ranges that presses show by themselves: force, and the gaps of double presses.
    pub(super) fn learn_ranges(&mut self, trials: &[Trial]) {
        let asked = trials.iter().filter(|trial| trial.asked.is_some());
        let mut forces = Vec::new();
        let mut gaps_ms = Vec::new();
        for trial in asked {
            let hardest = trial.touches.iter().map(|(_, touch)| touch.contact.force);
            forces.extend(hardest.max_by(f64::total_cmp));
            gaps_ms.extend(double_gap_ms(trial, self.tremor_ms));
        }
        self.force_range = range(&mut forces);
        self.double_tap_ms = quantile(&mut gaps_ms, GAP_QUANTILE)
            .map(|gap_ms| (GAP_MARGIN * gap_ms).max(DOUBLE_TAP_MS))
            .filter(|ms| *ms > DOUBLE_TAP_MS)
            .map(|ms| libm::ceil(ms / 50.0) as u32 * 50);
    }

    /// The text of a person's settings; with what they were counted to bring.
    #[must_use]
    pub fn toml(&self, counted: Option<(&Outcome, &Outcome)>) -> String {
        let mut text = String::new();
        if let Some((before, after)) = counted {
            let _ = writeln!(
                text,
                "# Recommended from {} presses: {} of them come out as meant with these settings, {} without; {} presses \
                 that nobody meant, {} without.",
                after.asked, after.right, before.right, after.wrong, before.wrong
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

/// The longest time without a finger inside a trial that asked for two presses: what parts them.
fn double_gap_ms(trial: &Trial, joined_ms: u32) -> Option<f64> {
    let asked = trial.asked.as_ref()?;
    if asked.length != super::Length::Twice {
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

fn range(forces: &mut [f64]) -> Option<[f64; 2]> {
    let least = NONE_SHARE * quantile(forces, FORCE_QUANTILES[0])?;
    let most = quantile(forces, FORCE_QUANTILES[1])?;
    (most - least >= LEAST_RANGE).then(|| [least, most].map(|force| force.clamp(0.0, 1.0)))
}

fn quantile(values: &mut [f64], share: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some(values[libm::round(share * last as f64) as usize])
}
