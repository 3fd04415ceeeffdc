//! The source's thread: frames into the queue, at the pace of the source.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Thread;
use std::time::{Duration, Instant};

use rtrb::{Producer, PushError};

use super::{Arrival, Arrived, Losses, NAP, SourceReport, now};
use crate::source::{Pace, Reading, Source};
use crate::types::Nanos;

/// The first reasons for skipping are told, then every hundredth.
const TOLD_SKIPS: u64 = 3;

pub(super) fn source_thread(
    mut source: Box<dyn Source>,
    mut frames: Producer<Arrived>,
    engine: &Thread,
    stop: &AtomicBool,
    losses: &Losses,
) -> SourceReport {
    let mut report = SourceReport::default();
    let mut first: Option<(Instant, Nanos)> = None;
    while !stop.load(Ordering::Relaxed) && !frames.is_abandoned() {
        let what = match source.read() {
            Ok(Reading::Frame(frame)) => Arrival::Frame(frame),
            Ok(Reading::Control(control)) => Arrival::Control(control),
            Ok(Reading::Skipped { reason, frames }) => {
                report.skipped += 1;
                losses.frames.fetch_add(frames, Ordering::Relaxed);
                if report.skipped <= TOLD_SKIPS || report.skipped.is_multiple_of(100) {
                    let skipped = report.skipped;
                    tracing::warn!("skipped what is no frame ({skipped} so far): {reason}");
                }
                engine.unpark();
                continue;
            }
            Ok(Reading::Gone { reason }) => {
                tracing::warn!("{reason}");
                losses.gone.store(true, Ordering::Release);
                engine.unpark();
                continue;
            }
            Ok(Reading::Idle) => continue,
            Ok(Reading::End) => break,
            Err(error) => {
                report.error = Some(error);
                break;
            }
        };
        if source.pace() == Pace::ByStamp {
            let (start, t0) = *first.get_or_insert_with(|| (now(), what.t_ns()));
            sleep_until(start + Duration::from_nanos(what.t_ns() - t0), stop);
        }
        if stop.load(Ordering::Relaxed) {
            break;
        }
        let full = match frames.push(Arrived { what, at: now() }) {
            Ok(()) => None,
            Err(PushError::Full(back)) => Some(back),
        };
        engine.unpark();
        match (full, source.pace()) {
            (None, _) => {}
            // A board goes on sending: its frame is lost, and said to be.
            (Some(_), Pace::ByDevice) => {
                losses.frames.fetch_add(1, Ordering::Relaxed);
            }
            (Some(back), Pace::ByStamp) => wait_for_room(&mut frames, back, engine, stop),
        }
    }
    drop(frames);
    engine.unpark();
    report
}

/// A file's frames are never lost: it waits until the engine has caught up.
fn wait_for_room(
    frames: &mut Producer<Arrived>,
    frame: Arrived,
    engine: &Thread,
    stop: &AtomicBool,
) {
    let mut waiting = frame;
    while !stop.load(Ordering::Relaxed) && !frames.is_abandoned() {
        match frames.push(waiting) {
            Ok(()) => break,
            Err(PushError::Full(back)) => waiting = back,
        }
        engine.unpark();
        std::thread::park_timeout(Duration::from_millis(1));
    }
    engine.unpark();
}

/// Sleeps, but wakes to stop.
fn sleep_until(due: Instant, stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        let left = due.saturating_duration_since(now());
        if left.is_zero() {
            return;
        }
        std::thread::park_timeout(left.min(NAP));
    }
}
