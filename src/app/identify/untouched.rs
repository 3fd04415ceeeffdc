//! Collects the frames of an untouched pad during play: a second of them, from one pause or several.

use rtrb::Producer;

use crate::engine::Input;
use crate::runtime::{EngineStep, StepListener};
use crate::types::{Frame, NANOS_PER_MS, Nanos, Part};

/// Untouched frames of this much time are collected, ...
const WINDOW_NS: Nanos = 1000 * NANOS_PER_MS;
/// ... at least so many of a slow board, and of a fast one the first so many.
const FEWEST_FRAMES: usize = 8;
const MOST_FRAMES: usize = 200;
/// The pad is not yet at rest so long after a touch, ...
const AFTER_TOUCH_NS: Nanos = 100 * NANOS_PER_MS;
/// ... and no longer in so many frames before one is found.
const BEFORE_TOUCH_FRAMES: usize = 3;

/// Frames in which nothing touched the pad.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct UntouchedWindow {
    /// Readings of each frame.
    pub(super) frames: Vec<Vec<f32>>,
    /// Time of the last one.
    pub(super) end_ns: Nanos,
    /// Channels that the game leaves out, as those of a lost electrode.
    pub(super) left_out: Vec<usize>,
}

/// Listens to a game. When the source disconnects it stops for good: a board that is connected again may be turned, and its
/// readings are then those of other channels.
pub(super) struct UntouchedFrames {
    /// None once the source has disconnected.
    windows: Option<Producer<UntouchedWindow>>,
    frames: Vec<Vec<f32>>,
    /// Time that these frames cover.
    covered_ns: Nanos,
    /// Time of the last untouched frame of this pause.
    last_ns: Option<Nanos>,
    /// No frame counts until then.
    rests_from_ns: Nanos,
    /// The readings so far of a frame that arrives in parts.
    partial: Vec<f32>,
    channels: usize,
    left_out: Vec<usize>,
}

impl UntouchedFrames {
    pub(super) fn new(windows: Producer<UntouchedWindow>, channels: usize) -> Self {
        Self {
            windows: Some(windows),
            frames: Vec::new(),
            covered_ns: 0,
            last_ns: None,
            rests_from_ns: 0,
            partial: Vec::new(),
            channels,
            left_out: Vec::new(),
        }
    }

    /// A touch is down at this time.
    fn end_pause(&mut self, t_ns: Nanos) {
        if self.last_ns.take().is_some() {
            let kept = self.frames.len().saturating_sub(BEFORE_TOUCH_FRAMES);
            self.frames.truncate(kept);
        }
        self.rests_from_ns = t_ns + AFTER_TOUCH_NS;
    }

    fn add_frame(&mut self, t_ns: Nanos, volts: &[f32]) {
        if t_ns < self.rests_from_ns {
            return;
        }
        if let Some(last_ns) = self.last_ns.replace(t_ns) {
            self.covered_ns += t_ns.saturating_sub(last_ns);
        }
        if self.frames.len() < MOST_FRAMES {
            self.frames.push(volts.to_vec());
        }
        if self.frames.len() >= FEWEST_FRAMES && self.covered_ns >= WINDOW_NS {
            self.covered_ns = 0;
            let window = UntouchedWindow {
                frames: std::mem::take(&mut self.frames),
                end_ns: t_ns,
                left_out: self.left_out.clone(),
            };
            if let Some(windows) = &mut self.windows {
                // While the last window is judged, others are dropped.
                let _ = windows.push(window);
            }
        }
    }
}

impl StepListener for UntouchedFrames {
    fn on_step(&mut self, step: &EngineStep<'_>) {
        if self.windows.is_none() {
            return;
        }
        if let Input::End { .. } = step.input {
            self.windows = None;
            self.frames.clear();
            return;
        }
        match step.input {
            Input::Frame(Frame { t_ns, .. }) | Input::Part(Part { t_ns, .. })
                if !step.touches.is_empty() =>
            {
                self.end_pause(*t_ns);
                self.partial.clear();
            }
            Input::Frame(frame) => self.add_frame(frame.t_ns, &frame.volts),
            Input::Matrix(sensing) => {
                let channels = 0..sensing.channels();
                self.left_out = channels.filter(|c| !sensing.uses_channel(*c)).collect();
            }
            Input::Part(part) => {
                if part.first == 0 {
                    self.partial.clear();
                }
                // After a lost part the rest of its frame is skipped.
                if part.first == self.partial.len() {
                    self.partial.extend_from_slice(&part.volts);
                }
                if self.partial.len() == self.channels {
                    let whole = std::mem::take(&mut self.partial);
                    self.add_frame(part.t_ns, &whole);
                    self.partial = whole;
                    self.partial.clear();
                }
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use rtrb::{Consumer, RingBuffer};

    use super::*;
    use crate::types::{Contact, Phase, Touch, TouchId};

    fn listener() -> (UntouchedFrames, Consumer<UntouchedWindow>) {
        let (sender, windows) = RingBuffer::new(1);
        (UntouchedFrames::new(sender, 4), windows)
    }

    fn step(listener: &mut UntouchedFrames, input: &Input, touches: &[Touch]) {
        listener.on_step(&EngineStep {
            input,
            touches,
            events: &[],
        });
    }

    fn frame(hundredths: u64) -> Input {
        Input::Frame(Frame {
            t_ns: hundredths * 10_000_000,
            volts: vec![hundredths as f32; 4],
        })
    }

    fn touch() -> Touch {
        Touch {
            id: TouchId(1),
            phase: Phase::Down,
            since_ns: 0,
            contact: Contact {
                centre_mm: [10.0, 10.0],
                area_mm2: 100.0,
                force: 0.5,
                confidence: 1.0,
            },
        }
    }

    #[test]
    fn a_second_without_touches_is_collected_from_several_pauses() {
        let (mut listener, mut windows) = listener();
        for t in 0..=50 {
            step(&mut listener, &frame(t), &[]);
        }
        for t in 51..80 {
            step(&mut listener, &frame(t), &[touch()]);
        }
        // At rest from 0.89 s on.
        for t in 80..139 {
            step(&mut listener, &frame(t), &[]);
        }
        assert!(windows.pop().is_err(), "0.99 s in all");
        step(&mut listener, &frame(139), &[]);
        let window = windows.pop().expect("a second");
        assert_eq!(window.end_ns, 1_390_000_000);
        let collected: Vec<f32> = window.frames.iter().map(|volts| volts[0]).collect();
        // The frames just before the touch may have been touched already.
        let expected = (0..=47).chain(89..=139).map(|t| t as f32);
        assert!(collected.iter().copied().eq(expected), "{collected:?}");
    }

    #[test]
    fn frames_in_parts_are_put_together_and_incomplete_ones_skipped() {
        let (mut listener, mut windows) = listener();
        let part = |first: usize, frame: u64| {
            Input::Part(Part {
                t_ns: (frame * 100 + first as u64) * 10_000_000,
                first,
                volts: vec![frame as f32; 2],
            })
        };
        for frame in 0..9 {
            step(&mut listener, &part(0, frame), &[]);
            if frame != 3 {
                step(&mut listener, &part(2, frame), &[]);
            }
        }
        let window = windows.pop().expect("eight whole frames");
        let whole: Vec<f32> = window.frames.iter().map(|volts| volts[0]).collect();
        assert_eq!(whole, [0.0, 1.0, 2.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    }

    #[test]
    fn a_board_that_was_away_is_not_judged() {
        let (mut listener, mut windows) = listener();
        step(&mut listener, &Input::End { t_ns: 0 }, &[]);
        for t in 0..200 {
            step(&mut listener, &frame(t), &[]);
        }
        assert!(windows.is_abandoned() && windows.pop().is_err());
    }
}
