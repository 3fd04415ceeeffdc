//! Delay statistics of repeated measurements.

use std::time::{Duration, Instant};

/// Measurements of a delay: enough for a 99th percentile.
pub(super) const ROUNDS: usize = 200;

/// Median and 99th percentile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Delay {
    median: Duration,
    p99: Duration,
}

impl Delay {
    /// Statistics of some times; `None` without any.
    pub(super) fn of(mut times: Vec<Duration>) -> Option<Self> {
        times.sort();
        let at = |percent: usize| times.get(times.len().saturating_sub(1) * percent / 100);
        Some(Self {
            median: *at(50)?,
            p99: *at(99)?,
        })
    }
}

impl std::fmt::Display for Delay {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let us = |time: Duration| time.as_micros();
        write!(f, "median {} us, p99 {} us", us(self.median), us(self.p99))
    }
}

#[allow(clippy::disallowed_methods, reason = "the doctor measures")]
pub(super) fn now() -> Instant {
    Instant::now()
}
