//! The summary of a game: frames, presses, timing.

use hdrhistogram::Histogram;

use crate::runtime::{SessionSummary, StageLatencies};

/// A press of this many frames is detected at any frame rate (`tests/lattice_session.rs`).
const SHORTEST_PRESS_FRAMES: f64 = 2.0;

/// The summary as text.
pub(super) fn summary_text(summary: &SessionSummary) -> String {
    let mut text = format!(
        "{}, {}",
        counted(summary.frames, "frame"),
        counted(summary.presses, "press")
    );
    if summary.lost_frames > 0 {
        text.push_str(&format!(
            ", {} lost ({} of them garbled)",
            counted(summary.lost_frames, "frame"),
            summary.skipped
        ));
    }
    if summary.repeated > 0 {
        text.push_str(&format!(
            ", {} repeat the one before bit for bit",
            counted(summary.repeated, "frame")
        ));
    }
    if summary.frames_per_s > 0.0 {
        text.push_str(&format!(
            ", {:.0} frames/s\nShortest press detected: {:.0} ms",
            summary.frames_per_s,
            SHORTEST_PRESS_FRAMES * 1e3 / summary.frames_per_s
        ));
    }
    if summary.frames > 0 {
        text.push_str(&format!(
            "\nframe to events: {}",
            quantiles(&summary.frame_to_events_ns)
        ));
    }
    if summary.presses > 0 {
        text.push_str(&format!(
            "\nframe to device: {}\n{}",
            quantiles(&summary.frame_to_device_ns),
            stage_times(&summary.stages)
        ));
    }
    if summary.late_events > 0 {
        text.push_str(&format!(
            "\n{} of {} were late, by up to {:.0} ms: is the computer busy?",
            summary.late_events,
            counted(summary.events, "event"),
            summary.longest_delay.as_secs_f64() * 1e3
        ));
    }
    text
}

fn quantiles(times_ns: &Histogram<u64>) -> String {
    let us = |quantile| times_ns.value_at_quantile(quantile) as f64 / 1000.0;
    format!("median {:.0} us, p99 {:.0} us", us(0.5), us(0.99))
}

/// Median and 99th percentile of each stage.
fn stage_times(stages: &StageLatencies) -> String {
    let stages = [
        ("queue", stages.queue),
        ("touches", stages.touches),
        ("events", stages.events),
        ("device", stages.device),
    ];
    let times = stages
        .map(|(name, spread)| format!("{name} {:.0} / {:.0} us", spread.median_us, spread.p99_us));
    format!("by stage, median / p99: {}", times.join(", "))
}

fn counted(count: u64, noun: &str) -> String {
    match (count, noun) {
        (1, _) => format!("1 {noun}"),
        (_, "press") => format!("{count} presses"),
        _ => format!("{count} {noun}s"),
    }
}
