//! A recording run through its engine once: what was seen at every frame, to scrub and step through.
//!
//! Memory is bounded: so many frames, with images packed to a byte a pixel.

use std::fmt::Write as _;
use std::sync::Arc;

use crate::engine::{Engine, Input};
use crate::pad::Pad;
use crate::profile::Profile;
use crate::runtime::{Signals, View};
use crate::types::{Event, Image, Nanos, Output, PixelGrid, Touch, ms_from_nanos};

/// Ten minutes at 100 frames/s; with 2500 pixels and 208 channels some 200 MB.
pub const MOST_FRAMES: usize = 60_000;
/// An image's value of 1 as a byte: the scale ends at a relative rise of 1.
const FULL: f32 = 255.0;
/// Events that a view keeps.
const VIEW_EVENTS: usize = 64;

/// One frame of it.
#[derive(Clone, Debug)]
struct Seen {
    t_ns: Nanos,
    volts: Vec<f32>,
    image: Vec<u8>,
    touches: Vec<Touch>,
    held: Vec<Output>,
    /// Events so far.
    events: usize,
    paused: bool,
    profile: Arc<Profile>,
}

/// What was recorded, frame by frame.
pub struct Tape {
    /// The pad that it was recorded on.
    pub pad: Pad,
    engine: Engine,
    grid: PixelGrid,
    seen: Vec<Seen>,
    events: Vec<Event>,
    fresh: Vec<Event>,
    first_ns: Nanos,
}

impl Tape {
    /// A tape of what an engine makes of the inputs that follow.
    #[must_use]
    pub fn new(pad: Pad, engine: Engine) -> Self {
        Self {
            pad,
            grid: engine.touches().image.grid,
            engine,
            seen: Vec::new(),
            events: Vec::new(),
            fresh: Vec::new(),
            first_ns: 0,
        }
    }

    /// Takes the next input; false when the tape is full.
    pub fn take(&mut self, input: &Input) -> bool {
        if let Input::Frame(frame) = input {
            // What was due before this frame came before it.
            while let Some(due_ns) = self.engine.next_due().filter(|due| *due <= frame.t_ns) {
                self.engine.input(&Input::Tick { due_ns }, &mut self.fresh);
            }
        }
        self.engine.input(input, &mut self.fresh);
        self.events.append(&mut self.fresh);
        if let Input::Frame(frame) = input {
            let state = self.engine.touches();
            if self.seen.is_empty() {
                self.first_ns = frame.t_ns;
            }
            self.seen.push(Seen {
                t_ns: frame.t_ns,
                volts: frame.volts.clone(),
                image: packed(state.image),
                touches: state.down.to_vec(),
                held: self.engine.held().collect(),
                events: self.events.len(),
                paused: self.engine.is_paused(),
                profile: Arc::clone(self.engine.profile()),
            });
        }
        self.seen.len() < MOST_FRAMES
    }

    /// Number of frames.
    #[must_use]
    pub fn len(&self) -> usize {
        self.seen.len()
    }

    /// Whether there is no frame.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.seen.is_empty()
    }

    /// Time of a frame from the first one, s.
    #[must_use]
    pub fn seconds(&self, frame: usize) -> f64 {
        self.seen.get(frame).map_or(0.0, |seen| {
            ms_from_nanos(seen.t_ns - self.first_ns) / 1000.0
        })
    }

    /// The last frame at or before a time from the first one, s.
    #[must_use]
    pub fn frame_at(&self, seconds: f64) -> usize {
        let t_ns = self.first_ns + (seconds.max(0.0) * 1e9) as Nanos;
        let after = self.seen.partition_point(|seen| seen.t_ns <= t_ns);
        after.saturating_sub(1)
    }

    /// What was to be seen at a frame.
    #[must_use]
    pub fn view(&self, frame: usize, mut view: View) -> View {
        let Some(seen) = self.seen.get(frame) else {
            return view;
        };
        view.t_ns = seen.t_ns;
        view.profile = Arc::clone(&seen.profile);
        view.paused = seen.paused;
        view.image = Image {
            grid: self.grid,
            values: seen.image.iter().map(|v| f32::from(*v) / FULL).collect(),
        };
        view.touches.clone_from(&seen.touches);
        view.held.clone_from(&seen.held);
        let from = seen.events.saturating_sub(VIEW_EVENTS);
        view.events = self.events[from..seen.events].iter().copied().collect();
        view.events_so_far = seen.events as u64;
        view.frames = frame as u64 + 1;
        view.frames_per_s = self.frames_per_s();
        view.signals = Signals {
            volts: seen.volts.clone(),
            ..Signals::default()
        };
        view
    }

    /// Frames a second, over all of it.
    #[must_use]
    pub fn frames_per_s(&self) -> f64 {
        let seconds = self.seconds(self.len().saturating_sub(1));
        if seconds > 0.0 {
            (self.len() - 1) as f64 / seconds
        } else {
            0.0
        }
    }

    /// When touches were down, as shares of the whole: for a picture of all of it.
    #[must_use]
    pub fn touched(&self, buckets: usize) -> Vec<bool> {
        let mut touched = vec![false; buckets];
        for (index, seen) in self.seen.iter().enumerate() {
            if !seen.touches.is_empty() {
                touched[index * buckets / self.seen.len()] = true;
            }
        }
        touched
    }

    /// A piece as frames in CSV, which `gelpad replay` reads; times begin at zero.
    #[must_use]
    pub fn csv(&self, frames: std::ops::RangeInclusive<usize>) -> String {
        let mut text = String::from("t_ms");
        let Some(first) = self.seen.get(*frames.start()) else {
            return text;
        };
        for channel in 0..first.volts.len() {
            // Writing to a String cannot fail.
            let _ = write!(text, ",v{channel}");
        }
        text.push('\n');
        let last = (*frames.end()).min(self.seen.len() - 1);
        for seen in &self.seen[*frames.start()..=last.max(*frames.start())] {
            let _ = write!(text, "{}", ms_from_nanos(seen.t_ns - first.t_ns));
            for volt in &seen.volts {
                let _ = write!(text, ",{volt}");
            }
            text.push('\n');
        }
        text
    }
}

fn packed(image: &Image) -> Vec<u8> {
    image
        .values
        .iter()
        .map(|value| (value * FULL).round().clamp(0.0, FULL) as u8)
        .collect()
}
