//! The table of `gelpad accuracy --scan`.

use std::fmt::Write as _;

use serde::Serialize;

use super::play::Played;
use crate::stats;

/// What one session gave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScanRow {
    /// The pad.
    pub pad: String,
    /// What was played.
    pub what: String,
    /// Frames a second.
    pub frames_per_s: f64,
    /// Read part by part, not frame by frame.
    pub by_parts: bool,
    /// Presses.
    pub presses: usize,
    /// Presses that were found.
    pub found: usize,
    /// Touches that are none of the presses.
    pub others: usize,
    /// Delay of a down, median and 95th percentile, ms.
    pub down_ms: Option<[f64; 2]>,
    /// Delay of an up, likewise.
    pub up_ms: Option<[f64; 2]>,
    /// Mean error of place where a press is first seen, mm.
    pub first_mm: Option<f64>,
    /// Mean error of place at the end of the first whole frame of a press, mm.
    pub whole_mm: Option<f64>,
    /// Mean distance by which a sliding finger is ahead of its touch, mm.
    pub lag_mm: Option<f64>,
}

/// All sessions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScanFindings {
    /// Seed of pads, presses and noise.
    pub seed: u64,
    /// A row a session.
    pub rows: Vec<ScanRow>,
}

impl ScanRow {
    pub(super) fn new(
        pad: &str,
        what: &str,
        frames_per_s: f64,
        by_parts: bool,
        played: &Played,
    ) -> Self {
        let spread = |ms: &[f64]| {
            let at = |share| stats::quantile(ms.iter().copied(), share);
            Some([at(0.5)?, at(0.95)?])
        };
        let mean = |mm: &[f64]| (!mm.is_empty()).then(|| stats::mean(mm.iter().copied()));
        Self {
            pad: pad.to_owned(),
            what: what.to_owned(),
            frames_per_s,
            by_parts,
            presses: played.presses,
            found: played.found,
            others: played.others,
            down_ms: spread(&played.down_ms),
            up_ms: spread(&played.up_ms),
            first_mm: mean(&played.first_mm),
            whole_mm: mean(&played.whole_mm),
            lag_mm: mean(&played.lag_mm),
        }
    }
}

impl ScanFindings {
    /// Everything as JSON.
    ///
    /// # Errors
    /// Values that JSON cannot hold.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self)
    }

    /// The table, for people.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = String::from(
            "| pad | what | frames/s | read | found | others | down, ms: median / p95 | up, ms | first, mm | whole frame, mm | lag, mm |\n\
             | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
        );
        for row in &self.rows {
            let pair = |values: Option<[f64; 2]>| {
                values.map_or(String::new(), |[a, b]| format!("{a:.1} / {b:.1}"))
            };
            let one = |value: Option<f64>| value.map_or(String::new(), |mm| format!("{mm:.2}"));
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} of {} | {} | {} | {} | {} | {} | {} |",
                row.pad,
                row.what,
                row.frames_per_s,
                if row.by_parts {
                    "part by part"
                } else {
                    "as moments"
                },
                row.found,
                row.presses,
                row.others,
                pair(row.down_ms),
                pair(row.up_ms),
                one(row.first_mm),
                one(row.whole_mm),
                one(row.lag_mm),
            );
        }
        text
    }
}
