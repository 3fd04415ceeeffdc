//! Latency of each stage, from a frame's arrival until the device has taken its events.
//!
//! ```text
//! arrival ──queue──▶ engine takes it ──touches──▶ places known ──events──▶ events made ──device──▶ device has taken them
//! ```

use std::time::Instant;

use hdrhistogram::Histogram;

use super::{nanos, new_histogram, now};

/// Latency of one stage, us.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LatencySummary {
    /// Number of measurements.
    pub count: u64,
    /// Median.
    pub median_us: f64,
    /// 99th percentile.
    pub p99_us: f64,
    /// Maximum.
    pub worst_us: f64,
}

impl LatencySummary {
    /// Summarizes times in ns.
    #[must_use]
    pub fn from_times(times_ns: &Histogram<u64>) -> Self {
        let us = |ns: u64| ns as f64 / 1e3;
        Self {
            count: times_ns.len(),
            median_us: us(times_ns.value_at_quantile(0.5)),
            p99_us: us(times_ns.value_at_quantile(0.99)),
            worst_us: us(times_ns.max()),
        }
    }
}

/// Latency of every stage since the start; updated once a second.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageLatencies {
    /// From a frame's arrival until the engine takes it.
    pub queue: LatencySummary,
    /// Until its touches are located.
    pub touches: LatencySummary,
    /// Until its events are made.
    pub events: LatencySummary,
    /// Until the device has taken them.
    pub device: LatencySummary,
    /// All stages together, for frames that cause events.
    pub frame_to_device: LatencySummary,
}

/// Statistics of the output's thread.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OutputStatistics {
    /// From the engine to the device.
    pub device: LatencySummary,
    /// From a frame's arrival to the device.
    pub frame_to_device: LatencySummary,
    /// Events that were sent late.
    pub late: u64,
    /// Rumble that the game requests: strong and weak motor, 0..1.
    pub rumble: [f32; 2],
}

/// Histograms of the engine's thread.
#[derive(Debug)]
pub(super) struct EngineTimes {
    pub(super) queue_ns: Histogram<u64>,
    pub(super) touches_ns: Histogram<u64>,
    pub(super) events_ns: Histogram<u64>,
    pub(super) frame_to_events_ns: Histogram<u64>,
}

impl EngineTimes {
    pub(super) fn new() -> Self {
        Self {
            queue_ns: new_histogram(),
            touches_ns: new_histogram(),
            events_ns: new_histogram(),
            frame_to_events_ns: new_histogram(),
        }
    }

    /// Records a frame by its arrival and the times at which the engine took it and had located its touches;
    /// its events are made now.
    pub(super) fn record(&mut self, arrived: Instant, taken: Instant, placed: Instant) {
        let done = now();
        let from = |before: Instant, after: Instant| nanos(after.saturating_duration_since(before));
        self.queue_ns.saturating_record(from(arrived, taken));
        self.touches_ns.saturating_record(from(taken, placed));
        self.events_ns.saturating_record(from(placed, done));
        self.frame_to_events_ns
            .saturating_record(from(arrived, done));
    }

    pub(super) fn stages(&self, emitted: &OutputStatistics) -> StageLatencies {
        StageLatencies {
            queue: LatencySummary::from_times(&self.queue_ns),
            touches: LatencySummary::from_times(&self.touches_ns),
            events: LatencySummary::from_times(&self.events_ns),
            device: emitted.device,
            frame_to_device: emitted.frame_to_device,
        }
    }
}
