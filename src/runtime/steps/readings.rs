//! The readings of the pad: frames, and parts of frames that are still being read.

use std::time::Instant;

use super::{EngineThread, SILENCE, SILENCE_IN_FRAME};
use crate::eit::REFERENCE_FRAMES;
use crate::engine::Input;
use crate::runtime::now;
use crate::types::{Frame, Nanos, Part};

/// Readings that a message names; of the others it gives the number.
const NAMED_CHANNELS: usize = 8;

impl EngineThread {
    pub(super) fn take_frame(&mut self, frame: Frame, at: Instant) {
        self.longest_silence = SILENCE;
        self.view.signals.volts.clone_from(&frame.volts);
        self.take_readings(frame.t_ns, at, true, &Input::Frame(frame));
    }

    /// A part of a frame. The view is published with every part, so that a touch is shown as soon as it is seen.
    pub(super) fn take_part(&mut self, part: Part, at: Instant) {
        let channels = self.engine.detector().channels();
        let span = part.first..part.first + part.volts.len();
        let ends_frame = span.end == channels;
        self.longest_silence = match ends_frame {
            true => SILENCE,
            false => SILENCE_IN_FRAME,
        };
        self.view.signals.volts.resize(channels, 0.0);
        self.view.signals.volts[span].copy_from_slice(&part.volts);
        self.take_readings(part.t_ns, at, ends_frame, &Input::Part(part));
    }

    fn take_readings(&mut self, t_ns: Nanos, at: Instant, ends_frame: bool, input: &Input) {
        if self.is_silent {
            self.is_silent = false;
            tracing::warn!("the board sends frames again");
        }
        if ends_frame {
            self.count_time(t_ns);
            self.view.frames += 1;
        }
        self.last_frame = Some((t_ns, at));
        self.view.t_ns = t_ns;
        let taken = now();
        let mut placed = taken;
        self.input_timed(input, Some(at), &mut || placed = now());
        self.times.record(at, taken, placed);
        self.measure_rate(at);
        self.publish();
        if ends_frame {
            self.log_changes();
        }
        self.rebuild();
    }

    /// Logs what the engine has noticed about the board.
    fn log_changes(&mut self) {
        let retaken = self.engine.references_retaken();
        if retaken > self.logged_retakes {
            self.logged_retakes = retaken;
            tracing::warn!(
                "the reference was taken again: a hand rested on the pad, or has left it"
            );
        }
        let (numbering, renumbered) = self.engine.board_numbering();
        if renumbered > self.logged_renumberings {
            self.logged_renumberings = renumbered;
            tracing::warn!(
                "the board was plugged in another way: it now counts {numbering}; play goes on"
            );
        }
        let hangs = self.engine.hangs();
        if hangs > self.logged_hangs {
            self.logged_hangs = hangs;
            tracing::warn!(
                "the board repeats one frame: keys are released until it sends another; if it stays so, reset the board"
            );
        }
        if self.view.frames == REFERENCE_FRAMES as u64 {
            let muted = self.engine.muted_channels();
            if !muted.is_empty() {
                tracing::warn!("{}", dead_at_start(&muted));
            }
        }
        self.log_electrodes();
    }
}

/// Channels (counted from 0) that were excluded at the start, in words.
fn dead_at_start(muted: &[usize]) -> String {
    let first: Vec<String> = muted
        .iter()
        .take(NAMED_CHANNELS)
        .map(|channel| (channel + 1).to_string())
        .collect();
    let more = match muted.len().saturating_sub(NAMED_CHANNELS) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!(
        "readings that are dead, loose or at the end of the converter's range at the start are left out: number {}{more} of each frame",
        first.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_dead_readings_are_named_and_the_others_counted() {
        let of = |count: usize| dead_at_start(&(3..3 + count).collect::<Vec<_>>());
        assert!(of(2).ends_with("number 4, 5 of each frame"), "{}", of(2));
        assert!(
            of(208).ends_with("11 and 200 more of each frame"),
            "{}",
            of(208)
        );
    }
}
