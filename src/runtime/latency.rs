//! How long each stage takes, from a frame's arrival to the moment at which the device has taken its events.
//!
//! ```text
//! arrival ──queue──▶ engine takes it ──touches──▶ places known ──events──▶ events made ──device──▶ device has taken them
//! ```

use std::time::Instant;

use hdrhistogram::Histogram;

use super::{nanos, new_histogram, now};

/// One stage so far, us.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// How many were measured.
    pub count: u64,
    /// Half are faster.
    pub median_us: f64,
    /// One of a hundred is slower.
    pub p99_us: f64,
    /// The slowest.
    pub worst_us: f64,
}

impl Spread {
    /// The spread of times in ns.
    #[must_use]
    pub fn of(times_ns: &Histogram<u64>) -> Self {
        let us = |ns: u64| ns as f64 / 1e3;
        Self {
            count: times_ns.len(),
            median_us: us(times_ns.value_at_quantile(0.5)),
            p99_us: us(times_ns.value_at_quantile(0.99)),
            worst_us: us(times_ns.max()),
        }
    }
}

/// Every stage so far; a view has it once a second.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stages {
    /// From a frame's arrival until the engine takes it.
    pub queue: Spread,
    /// Until its image and touches are known.
    pub touches: Spread,
    /// Until its events are made.
    pub events: Spread,
    /// From then on until the device has taken them.
    pub device: Spread,
    /// All of them, for frames with events.
    pub frame_to_device: Spread,
}

/// What the output's thread tells while it plays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Emitted {
    /// From the engine to the device.
    pub device: Spread,
    /// From a frame's arrival to the device.
    pub frame_to_device: Spread,
    /// Events that went out late.
    pub late: u64,
    /// How hard a game shakes the pad: the strong motor and the weak one, 0..1.
    pub rumble: [f32; 2],
}

/// Times of the stages in the engine's thread.
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

    /// Notes a frame that arrived, was taken, had its touches known, and has now its events made.
    pub(super) fn note(&mut self, arrived: Instant, taken: Instant, placed: Instant) {
        let done = now();
        let from = |before: Instant, after: Instant| nanos(after.saturating_duration_since(before));
        self.queue_ns.saturating_record(from(arrived, taken));
        self.touches_ns.saturating_record(from(taken, placed));
        self.events_ns.saturating_record(from(placed, done));
        self.frame_to_events_ns
            .saturating_record(from(arrived, done));
    }

    pub(super) fn stages(&self, emitted: &Emitted) -> Stages {
        Stages {
            queue: Spread::of(&self.queue_ns),
            touches: Spread::of(&self.touches_ns),
            events: Spread::of(&self.events_ns),
            device: emitted.device,
            frame_to_device: emitted.frame_to_device,
        }
    }
}
