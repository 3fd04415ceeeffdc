//! The source's thread: readings into the queue, at the pace of the source.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Thread;
use std::time::{Duration, Instant};

use rtrb::{Producer, PushError};

use super::{Arrival, NAP, SourceInput, SourceReport, SourceStatus, now};
use crate::source::{Source, SourcePace, SourceReading};
use crate::types::{Frame, Nanos, Part};

/// The first skipped inputs are logged one by one, then every hundredth.
const LOGGED_SKIPS: u64 = 3;
/// So many repeated frames are logged first: a coarse converter may repeat a few.
const LOGGED_REPEATS: u64 = 10;

pub(super) fn source_thread(
    source: Box<dyn Source>,
    frames: Producer<Arrival>,
    engine: &Thread,
    stop: &AtomicBool,
    status: &SourceStatus,
) -> SourceReport {
    let mut feeder = Feeder {
        source,
        frames,
        engine,
        stop,
        status,
        first: None,
        last_volts: Vec::new(),
        repeats: false,
        has_lost_part: false,
        report: SourceReport::default(),
    };
    while !feeder.is_over() {
        match feeder.source.read() {
            Ok(SourceReading::End) => break,
            Ok(reading) => feeder.take_reading(reading),
            Err(error) => {
                feeder.report.error = Some(error);
                break;
            }
        }
    }
    drop(feeder.frames);
    engine.unpark();
    feeder.report
}

struct Feeder<'a> {
    source: Box<dyn Source>,
    frames: Producer<Arrival>,
    engine: &'a Thread,
    stop: &'a AtomicBool,
    status: &'a SourceStatus,
    /// When the first reading was played, and its time stamp.
    first: Option<(Instant, Nanos)>,
    /// The voltages of the last frame.
    last_volts: Vec<f32>,
    /// The parts so far of the present frame repeat those of the last one.
    repeats: bool,
    /// A part of the present frame was lost.
    has_lost_part: bool,
    report: SourceReport,
}

impl Feeder<'_> {
    fn is_over(&self) -> bool {
        self.stop.load(Ordering::Relaxed) || self.frames.is_abandoned()
    }

    fn take_reading(&mut self, reading: SourceReading) {
        match reading {
            SourceReading::Frame(frame) => {
                self.count_repeat(&frame);
                self.feed(SourceInput::Frame(frame));
            }
            SourceReading::Part(part) => {
                self.count_repeated_part(&part);
                self.feed(SourceInput::Part(part));
            }
            SourceReading::Control(control) => self.feed(SourceInput::Control(control)),
            SourceReading::Skipped { reason, frames } => {
                self.report.skipped += 1;
                self.status.lost_frames.fetch_add(frames, Ordering::Relaxed);
                let skipped = self.report.skipped;
                if skipped <= LOGGED_SKIPS || skipped.is_multiple_of(100) {
                    tracing::warn!(
                        "skipped input that is not a frame ({skipped} so far): {reason}"
                    );
                }
                if let Ok(mut last) = self.status.skip_reason.lock() {
                    *last = Some(reason);
                }
                self.engine.unpark();
            }
            SourceReading::Disconnected { reason } => {
                tracing::warn!("{reason}");
                self.status.is_disconnected.store(true, Ordering::Release);
                self.engine.unpark();
            }
            SourceReading::Idle | SourceReading::End => {}
        }
    }

    /// Counts frames that repeat the one before bit for bit: noise makes every measurement different, so the board sent
    /// the same one twice.
    fn count_repeat(&mut self, frame: &Frame) {
        if are_same(&frame.volts, &self.last_volts) {
            self.report_repeat();
        }
        self.last_volts.clone_from(&frame.volts);
    }

    /// The same for a frame that arrives in parts.
    fn count_repeated_part(&mut self, part: &Part) {
        let span = part.first..part.first + part.volts.len();
        self.repeats |= part.first == 0;
        match self.last_volts.get_mut(span.clone()) {
            Some(last) => {
                self.repeats &= are_same(&part.volts, last);
                last.copy_from_slice(&part.volts);
            }
            None => {
                self.repeats = false;
                self.last_volts.resize(span.end, f32::NAN);
                self.last_volts[span.clone()].copy_from_slice(&part.volts);
            }
        }
        if self.repeats && span.end == self.last_volts.len() {
            self.report_repeat();
        }
    }

    fn report_repeat(&mut self) {
        self.report.repeated += 1;
        let repeated = self.report.repeated;
        if repeated == LOGGED_REPEATS || repeated.is_multiple_of(1000) {
            tracing::warn!(
                "{repeated} frames so far repeat the one before bit for bit: the board sends measurements twice, or is \
                 stuck; touches are as late as its new measurements"
            );
        }
    }

    /// Counts the frame of an input that found the queue full; once for all parts of a frame.
    fn count_lost(&mut self, input: &SourceInput) {
        let is_counted = match input {
            SourceInput::Part(part) => part.first > 0 && self.has_lost_part,
            _ => false,
        };
        self.has_lost_part = matches!(input, SourceInput::Part(_));
        if !is_counted {
            self.status.lost_frames.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Queues an input when it is due.
    fn feed(&mut self, input: SourceInput) {
        let pace = self.source.pace();
        if pace == SourcePace::ByStamp {
            let (start, t0) = *self.first.get_or_insert_with(|| (now(), input.t_ns()));
            sleep_until(start + Duration::from_nanos(input.t_ns() - t0), self.stop);
        }
        if self.stop.load(Ordering::Relaxed) {
            return;
        }
        let pushed = self.frames.push(Arrival { input, at: now() });
        self.engine.unpark();
        match (pushed, pace) {
            (Ok(()), _) => self.has_lost_part = false,
            // A board keeps sending, so its frame is lost.
            (Err(PushError::Full(back)), SourcePace::ByDevice) => self.count_lost(&back.input),
            (Err(PushError::Full(back)), SourcePace::ByStamp) => self.push_when_room(back),
        }
    }

    /// A file's frames are never lost: they wait until the engine has caught up.
    fn push_when_room(&mut self, arrival: Arrival) {
        let mut waiting = arrival;
        while !self.is_over() {
            match self.frames.push(waiting) {
                Ok(()) => break,
                Err(PushError::Full(back)) => waiting = back,
            }
            self.engine.unpark();
            std::thread::park_timeout(Duration::from_millis(1));
        }
        self.engine.unpark();
    }
}

fn are_same(volts: &[f32], last: &[f32]) -> bool {
    let bits = |volt: &f32| volt.to_bits();
    volts.iter().map(bits).eq(last.iter().map(bits))
}

/// Sleeps until a time, or until `stop` is set.
fn sleep_until(due: Instant, stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        let left = due.saturating_duration_since(now());
        if left.is_zero() {
            return;
        }
        std::thread::park_timeout(left.min(NAP));
    }
}
