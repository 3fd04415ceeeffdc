//! The output's thread: events to the device when they are due.

use std::time::{Duration, Instant};

use hdrhistogram::Histogram;
use rtrb::Consumer;

use super::latency::{Emitted, Spread};
use super::schedule::{Due, LATE, Schedule};
use super::{EVENT_QUEUE, NAP, OutputReport, nanos, new_histogram, now};
use crate::output::{Device, Held, OutputError};
use crate::types::Action;

/// How often it says how it goes.
const TELL: Duration = Duration::from_millis(100);
/// What waits for its time at the end gets so long.
const ENCORE: Duration = Duration::from_millis(500);

pub(super) fn output_thread(
    device: Box<dyn Device>,
    events: Consumer<Due>,
    told: triple_buffer::Input<Emitted>,
) -> OutputReport {
    let mut emitter = Emitter {
        held: Held::new(device),
        schedule: Schedule::default(),
        device_ns: new_histogram(),
        told,
        next_told: now(),
        report: OutputReport::default(),
    };
    if let Err(error) = emitter.run(events) {
        emitter.report.error = Some(error);
    }
    emitter.report.device_ns = emitter.device_ns;
    emitter.report
}

struct Emitter {
    held: Held,
    schedule: Schedule,
    device_ns: Histogram<u64>,
    told: triple_buffer::Input<Emitted>,
    next_told: Instant,
    report: OutputReport,
}

impl Emitter {
    fn run(&mut self, mut events: Consumer<Due>) -> Result<(), OutputError> {
        let mut end: Option<Instant> = None;
        loop {
            let is_last = events.is_abandoned();
            // A device that falls behind makes the engine wait.
            while self.schedule.len() < EVENT_QUEUE
                && let Ok(due) = events.pop()
            {
                self.schedule.take(due);
            }
            if is_last && events.is_empty() {
                self.schedule.whole();
                let end = *end.get_or_insert_with(|| now() + ENCORE);
                if self.schedule.len() == 0 || now() >= end {
                    return self.held.flush();
                }
            }
            self.emit()?;
            self.held.idle()?;
            self.tell();
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

    /// Sends what is due, one report for each batch.
    fn emit(&mut self) -> Result<(), OutputError> {
        let mut batch: Vec<(Due, Instant)> = Vec::new();
        while let Some((due, at)) = self.schedule.next(now()) {
            self.held.send(&due.event)?;
            batch.push((due, at));
            if due.ends_batch {
                self.held.flush()?;
                batch.drain(..).for_each(|(due, at)| self.note(&due, at));
            }
        }
        if !batch.is_empty() {
            self.held.flush()?;
            batch.drain(..).for_each(|(due, at)| self.note(&due, at));
        }
        Ok(())
    }

    /// Notes an event that the device has taken.
    fn note(&mut self, due: &Due, at: Instant) {
        let taken = now();
        let report = &mut self.report;
        let since = |before: Instant| nanos(taken.saturating_duration_since(before));
        // From when it was made or, where it had to wait, from when it might go.
        self.device_ns.saturating_record(since(due.made.max(at)));
        if let Some(arrived) = due.frame_at {
            report.frame_to_device_ns.saturating_record(since(arrived));
        }
        let late = taken.saturating_duration_since(at);
        report.events += 1;
        report.late += u64::from(late > LATE);
        report.latest = report.latest.max(late);
        report.presses += u64::from(matches!(due.event.action, Action::Press(_)));
    }

    /// How it goes, for the views.
    fn tell(&mut self) {
        if now() < self.next_told {
            return;
        }
        self.next_told = now() + TELL;
        self.told.write(Emitted {
            device: Spread::of(&self.device_ns),
            frame_to_device: Spread::of(&self.report.frame_to_device_ns),
            late: self.report.late,
            rumble: self.held.rumble(),
        });
    }
}
