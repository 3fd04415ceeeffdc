//! A recording played through its engine once, with the state at every frame, to scrub and step through.
//!
//! Memory is bounded: at most [`MOST_FRAMES`] frames, with one byte per pixel.

use std::fmt::Write as _;
use std::sync::Arc;

use crate::eit::REFERENCE_FRAMES;
use crate::engine::{Engine, Input};
use crate::pad::Pad;
use crate::profile::Profile;
use crate::runtime::{Signals, View};
use crate::types::{Event, FrameAssembler, Image, Nanos, Output, PixelGrid, Touch, ms_from_nanos};

/// Limit: ten minutes at 100 frames/s, 200 MB with 2500 pixels and 208 channels.
pub const MOST_FRAMES: usize = 60_000;
/// The byte for an image value of 1; larger values are cut.
const FULL_SCALE: f32 = 255.0;
/// Events that a view keeps.
const VIEW_EVENTS: usize = 64;

/// The state at a frame.
#[derive(Clone, Debug)]
struct FrameState {
    t_ns: Nanos,
    volts: Vec<f32>,
    image: Vec<u8>,
    touches: Vec<Touch>,
    held: Vec<Output>,
    /// Number of events up to this frame.
    events: usize,
    paused: bool,
    profile: Arc<Profile>,
}

/// The states of a recording at its frames.
pub struct RecordingTimeline {
    /// The pad of the recording.
    pub pad: Pad,
    engine: Engine,
    grid: PixelGrid,
    frames: Vec<FrameState>,
    events: Vec<Event>,
    fresh: Vec<Event>,
    assembler: FrameAssembler,
    first_ns: Nanos,
}

impl RecordingTimeline {
    /// An empty timeline; inputs are played through the engine.
    #[must_use]
    pub fn new(pad: Pad, mut engine: Engine) -> Self {
        Self {
            pad,
            grid: engine.image().grid,
            engine,
            frames: Vec::new(),
            events: Vec::new(),
            fresh: Vec::new(),
            assembler: FrameAssembler::default(),
            first_ns: 0,
        }
    }

    /// Plays the next input; false when the timeline is full.
    pub fn add_input(&mut self, input: &Input) -> bool {
        let t_ns = match input {
            Input::Frame(frame) => Some(frame.t_ns),
            Input::Part(part) => Some(part.t_ns),
            _ => None,
        };
        if let Some(t_ns) = t_ns {
            // Ticks that are due before these readings come first.
            while let Some(due_ns) = self.engine.next_due().filter(|due| *due <= t_ns) {
                self.engine.input(&Input::Tick { due_ns }, &mut self.fresh);
            }
        }
        self.engine.input(input, &mut self.fresh);
        self.events.append(&mut self.fresh);
        let assembled;
        let frame = match input {
            Input::Frame(frame) => Some(frame),
            Input::Part(part) => {
                assembled = self.assembler.add(part, self.pad.channels());
                assembled.as_ref()
            }
            _ => None,
        };
        if let Some(frame) = frame {
            if self.frames.is_empty() {
                self.first_ns = frame.t_ns;
            }
            self.frames.push(FrameState {
                t_ns: frame.t_ns,
                volts: frame.volts.clone(),
                image: pack_image(self.engine.image()),
                touches: self.engine.touches_down().to_vec(),
                held: self.engine.held_outputs().collect(),
                events: self.events.len(),
                paused: self.engine.is_paused(),
                profile: Arc::clone(self.engine.profile()),
            });
        }
        self.frames.len() < MOST_FRAMES
    }

    /// Number of frames.
    #[must_use]
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether there is no frame.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Time of a frame from the first one, s.
    #[must_use]
    pub fn seconds(&self, frame: usize) -> f64 {
        self.frames.get(frame).map_or(0.0, |state| {
            ms_from_nanos(state.t_ns - self.first_ns) / 1000.0
        })
    }

    /// The last frame at or before a time from the first one, s.
    #[must_use]
    pub fn frame_at(&self, seconds: f64) -> usize {
        let t_ns = self.first_ns + (seconds.max(0.0) * 1e9) as Nanos;
        let after = self.frames.partition_point(|state| state.t_ns <= t_ns);
        after.saturating_sub(1)
    }

    /// Sets a view to the state at a frame.
    #[must_use]
    pub fn view(&self, frame: usize, mut view: View) -> View {
        let Some(state) = self.frames.get(frame) else {
            return view;
        };
        view.t_ns = state.t_ns;
        view.profile = Arc::clone(&state.profile);
        view.paused = state.paused;
        view.image = Image {
            grid: self.grid,
            values: state
                .image
                .iter()
                .map(|v| f32::from(*v) / FULL_SCALE)
                .collect(),
        };
        view.touches.clone_from(&state.touches);
        view.held.clone_from(&state.held);
        let from = state.events.saturating_sub(VIEW_EVENTS);
        view.events = self.events[from..state.events].iter().copied().collect();
        view.events_so_far = state.events as u64;
        view.frames = frame as u64 + 1;
        view.frames_per_s = self.frames_per_s();
        view.signals = Signals {
            volts: state.volts.clone(),
            ..Signals::default()
        };
        view
    }

    /// All events, a line each, as `gelpad replay FILE --print events` prints them.
    #[must_use]
    pub fn event_lines(&self) -> Vec<String> {
        self.events.iter().map(Event::to_string).collect()
    }

    /// Mean frame rate, frames/s.
    #[must_use]
    pub fn frames_per_s(&self) -> f64 {
        let seconds = self.seconds(self.len().saturating_sub(1));
        if seconds > 0.0 {
            (self.len() - 1) as f64 / seconds
        } else {
            0.0
        }
    }

    /// Splits the timeline into equal parts; returns for each whether a touch was down.
    #[must_use]
    pub fn touched_parts(&self, buckets: usize) -> Vec<bool> {
        let mut touched = vec![false; buckets];
        for (index, state) in self.frames.iter().enumerate() {
            if !state.touches.is_empty() {
                touched[index * buckets / self.frames.len()] = true;
            }
        }
        touched
    }

    /// A range of frames as CSV for `gelpad replay`; times start at 0. A range that begins within a touch begins at the rest
    /// before it instead: a replay takes its reference from the first frames.
    #[must_use]
    pub fn csv(&self, frames: std::ops::RangeInclusive<usize>) -> String {
        let mut text = String::from("t_ms");
        let start = self.rest_before(*frames.start());
        let Some(first) = self.frames.get(start) else {
            return text;
        };
        for channel in 0..first.volts.len() {
            // Writing to a String cannot fail.
            let _ = write!(text, ",v{channel}");
        }
        text.push('\n');
        let last = (*frames.end()).min(self.frames.len() - 1);
        for state in &self.frames[start..=last.max(start)] {
            let _ = write!(text, "{}", ms_from_nanos(state.t_ns - first.t_ns));
            for volt in &state.volts {
                let _ = write!(text, ",{volt}");
            }
            text.push('\n');
        }
        text
    }

    /// The last frame up to this one at which a replay finds its reference: no touch is down in it and those that follow. The
    /// first frame if there is none.
    fn rest_before(&self, frame: usize) -> usize {
        let is_rest = |start: &usize| {
            self.frames[*start..]
                .first_chunk::<REFERENCE_FRAMES>()
                .is_some_and(|states| states.iter().all(|state| state.touches.is_empty()))
        };
        let last = frame.min(self.frames.len().saturating_sub(1));
        (0..=last).rev().find(is_rest).unwrap_or(0)
    }
}

fn pack_image(image: &Image) -> Vec<u8> {
    image
        .values
        .iter()
        .map(|value| (value * FULL_SCALE).round().clamp(0.0, FULL_SCALE) as u8)
        .collect()
}
