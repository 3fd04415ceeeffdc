//! The output's thread: sends events to the device when they are due.

use std::time::{Duration, Instant};

use hdrhistogram::Histogram;
use rtrb::Consumer;

use super::latency::{LatencySummary, OutputStatistics};
use super::schedule::{Due, LATE, Schedule};
use super::{EVENT_QUEUE, NAP, OutputReport, nanos, new_histogram, now};
use crate::output::{OutputDevice, OutputError, ReleaseOnDrop};
use crate::types::Action;

/// How often the statistics are published.
const PUBLISH_PERIOD: Duration = Duration::from_millis(100);
/// After the engine has ended, events that are not due yet are waited for this long.
const DRAIN_TIMEOUT: Duration = Duration::from_millis(500);

pub(super) fn output_thread(
    device: Box<dyn OutputDevice>,
    events: Consumer<Due>,
    emitted: triple_buffer::Input<OutputStatistics>,
) -> OutputReport {
    let mut emitter = Emitter {
        device: ReleaseOnDrop::new(device),
        schedule: Schedule::default(),
        device_ns: new_histogram(),
        emitted,
        next_publish: now(),
        report: OutputReport::default(),
    };
    if let Err(error) = emitter.run(events) {
        emitter.report.error = Some(error);
    }
    emitter.report.device_ns = emitter.device_ns;
    emitter.report
}

struct Emitter {
    device: ReleaseOnDrop,
    schedule: Schedule,
    device_ns: Histogram<u64>,
    emitted: triple_buffer::Input<OutputStatistics>,
    next_publish: Instant,
    report: OutputReport,
}

impl Emitter {
    /// Sends events until the engine has ended and all are sent, or [`DRAIN_TIMEOUT`] has passed since.
    fn run(&mut self, mut events: Consumer<Due>) -> Result<(), OutputError> {
        let mut end: Option<Instant> = None;
        loop {
            let is_last = events.is_abandoned();
            // If the device falls behind, the queue fills up and the engine waits.
            while self.schedule.len() < EVENT_QUEUE
                && let Ok(due) = events.pop()
            {
                self.schedule.add(due);
            }
            if is_last && events.is_empty() {
                self.schedule.end_batch();
                let end = *end.get_or_insert_with(|| now() + DRAIN_TIMEOUT);
                if self.schedule.len() == 0 || now() >= end {
                    return self.device.flush();
                }
            }
            self.emit()?;
            self.device.idle()?;
            self.publish();
            if events.is_empty() {
                let left = self.schedule.next_at();
                let left = left.map_or(NAP, |at| at.saturating_duration_since(now()));
                let is_over = is_last && self.schedule.len() == 0;
                if !(left.is_zero() || is_over) {
                    std::thread::park_timeout(left.min(NAP));
                }
            }
        }
    }

    /// Sends what is due, one flush for each batch.
    fn emit(&mut self) -> Result<(), OutputError> {
        let mut batch: Vec<(Due, Instant)> = Vec::new();
        while let Some((due, at)) = self.schedule.next(now()) {
            self.device.send(&due.event)?;
            batch.push((due, at));
            if due.ends_batch {
                self.device.flush()?;
                batch
                    .drain(..)
                    .for_each(|(due, at)| self.record_sent(&due, at));
            }
        }
        if !batch.is_empty() {
            self.device.flush()?;
            batch
                .drain(..)
                .for_each(|(due, at)| self.record_sent(&due, at));
        }
        Ok(())
    }

    /// Records when the device took an event.
    fn record_sent(&mut self, due: &Due, at: Instant) {
        let taken = now();
        let report = &mut self.report;
        let since = |before: Instant| nanos(taken.saturating_duration_since(before));
        // From when the event was made or, if it had to wait, from when it was due.
        self.device_ns.saturating_record(since(due.made.max(at)));
        if let Some(arrived) = due.frame_at {
            report.frame_to_device_ns.saturating_record(since(arrived));
        }
        let late = taken.saturating_duration_since(at);
        report.events += 1;
        report.late += u64::from(late > LATE);
        report.longest_delay = report.longest_delay.max(late);
        report.presses += u64::from(matches!(due.event.action, Action::Press(_)));
    }

    /// Publishes the statistics for the views.
    fn publish(&mut self) {
        if now() < self.next_publish {
            return;
        }
        self.next_publish = now() + PUBLISH_PERIOD;
        self.emitted.write(OutputStatistics {
            device: LatencySummary::from_times(&self.device_ns),
            frame_to_device: LatencySummary::from_times(&self.report.frame_to_device_ns),
            late: self.report.late,
            rumble: self.device.rumble(),
        });
    }
}
