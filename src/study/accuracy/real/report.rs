//! The table of `gelpad accuracy --real`.

use std::fmt;

use serde::Serialize;

use super::play::Played;
use super::{Condition, Goal};
use crate::study::accuracy::{Share, Spread};

/// What one condition gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ConditionFindings {
    /// Its name.
    pub name: String,
    /// Disturbances, as `--disturb` takes them.
    pub disturbances: String,
    /// White noise, dB.
    pub snr_db: f64,
    /// Fingers not found while they pressed.
    pub missed: Share,
    /// Fingers not found in the first frame of their press.
    pub late: Share,
    /// Presses with the right number of touches in their last frame.
    pub counted_right: Share,
    /// Errors of place where a finger was first found, mm.
    pub first_mm: Spread,
    /// Errors of place in the last frame of the press, mm.
    pub last_mm: Spread,
    /// The least that `first_mm` can be in the mean with unknown place, size and strength of round fingers (Cramer-Rao), mm; a method
    /// that expects typical fingers can be below it. `null` where more than white noise disturbs or fingers are not round.
    pub bound_mm: f64,
    /// Touches that no finger made.
    pub false_touches: usize,
    /// Presses after which a touch is down half a second after the lift, where that is looked at.
    pub stuck: usize,
    /// Longest time of a touch without a finger, ms.
    pub longest_ms: f64,
    /// Seconds played.
    pub seconds: f64,
    /// Whether every goal of the condition is met; `None` of a condition without a goal.
    pub is_met: Option<bool>,
}

/// All conditions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RealFindings {
    /// Seed of pads, presses and disturbances.
    pub seed: u64,
    /// A row a condition.
    pub conditions: Vec<ConditionFindings>,
}

impl ConditionFindings {
    pub(super) fn new(condition: &Condition, played: &[Played]) -> Self {
        let sum = |count: fn(&Played) -> usize| played.iter().map(count).sum::<usize>();
        let errors =
            |list: fn(&Played) -> &Vec<f64>| Spread::new(played.iter().flat_map(list).copied());
        let fingers = sum(|one| one.fingers);
        let mut findings = Self {
            name: condition.name.to_owned(),
            disturbances: condition
                .disturbances
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
                .join(","),
            snr_db: condition.snr_db,
            missed: Share::new(sum(|one| one.missed), fingers),
            late: Share::new(sum(|one| one.late), fingers),
            counted_right: Share::new(sum(|one| one.counted_right), sum(|one| one.presses)),
            first_mm: errors(|one| &one.first_errors_mm),
            last_mm: errors(|one| &one.last_errors_mm),
            bound_mm: errors(|one| &one.bounds_mm).mean,
            false_touches: sum(|one| one.false_touches),
            stuck: sum(|one| one.stuck),
            longest_ms: played.iter().map(|one| one.longest_ms).fold(0.0, f64::max),
            seconds: played.iter().map(|one| one.seconds).sum(),
            is_met: None,
        };
        findings.is_met =
            (condition.goal != Goal::default()).then(|| findings.meets(condition.goal));
        findings
    }

    fn meets(&self, goal: Goal) -> bool {
        let below =
            |value: f64, most: Option<f64>| most.is_none_or(|most| value <= most || value.is_nan());
        below(self.missed.share, goal.missed)
            && below(self.first_mm.mean, goal.mean_mm)
            && below(self.last_mm.mean, goal.held_mm)
            && goal
                .false_touches
                .is_none_or(|most| self.false_touches <= most)
            && below(self.longest_ms, goal.longest_ms)
            && self.stuck == 0
            && goal
                .right
                .is_none_or(|least| self.counted_right.share >= least)
    }
}

/// The first line of the table.
pub const TABLE_HEADER: &str = "condition                            missed  (95 %)       late   right   first mm  last mm  bound mm  false  stuck  longest ms  goal";

impl fmt::Display for ConditionFindings {
    /// A line of the table.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: f64| number(100.0 * share, 1);
        write!(
            formatter,
            "{:<36} {:>5} % ({:>4}-{:>5}) {:>5} % {:>5} % {:>7} {:>8} {:>9} {:>6} {:>6} {:>9.0}   {}",
            self.name,
            percent(self.missed.share),
            percent(self.missed.low),
            percent(self.missed.high),
            percent(self.late.share),
            percent(self.counted_right.share),
            number(self.first_mm.mean, 2),
            number(self.last_mm.mean, 2),
            number(self.bound_mm, 2),
            self.false_touches,
            self.stuck,
            self.longest_ms,
            match self.is_met {
                Some(true) => "met",
                Some(false) => "NOT MET",
                None => "-",
            },
        )
    }
}

impl RealFindings {
    /// As JSON.
    ///
    /// # Errors
    /// None in practice: every value can be written.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self)
    }
}

/// A number with some decimals; a dash where there is none, as on an untouched pad.
fn number(value: f64, decimals: usize) -> String {
    if value.is_nan() {
        "-".to_owned()
    } else {
        format!("{value:.decimals$}")
    }
}
