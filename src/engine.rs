//! The stages in order: inputs in, events out. Pure and deterministic.
//!
//! Invariant: the same inputs in the same order give the same events, bit for bit, at any speed. Nothing here
//! reads a clock, starts a thread or does IO; time comes with the input.

use std::sync::Arc;

use crate::gesture::Gestures;
use crate::pad::Pad;
use crate::profile::Profile;
use crate::touch::{Correction, Detector, FrameTouches, Sensing};
use crate::types::{Control, Event, Frame, Nanos, Output, Touch};

/// Everything that can change what the engine does next.
#[derive(Clone, Debug)]
pub enum Input {
    /// A reading of the pad, with one voltage for each of the pad's channels.
    Frame(Frame),
    /// What gamepads and switches say: a source without image.
    Control(Control),
    /// A time that [`Engine::next_due`] gave has come.
    Tick {
        /// That time, never the clock's.
        due_ns: Nanos,
    },
    /// Another profile, as soon as the outputs are up: a second later at most, and then they are released.
    Profile {
        /// When it takes over.
        t_ns: Nanos,
        /// The profile.
        profile: Arc<Profile>,
    },
    /// The player pauses, or goes on.
    Pause {
        /// When.
        t_ns: Nanos,
    },
    /// Another matrix and other weights of the same pad from now on: an electrode was lost, or is back.
    Matrix(Arc<Sensing>),
    /// The pad counts as untouched as it is now; what is held is released.
    Rezero {
        /// When.
        t_ns: Nanos,
    },
    /// Frames were lost before the engine.
    Lost {
        /// How many.
        frames: u64,
    },
    /// The source has ended or gone: whatever is held is released.
    End {
        /// When.
        t_ns: Nanos,
    },
}

/// The stages and their state.
#[derive(Clone, Debug)]
pub struct Engine {
    detector: Detector,
    gestures: Gestures,
    changed: Vec<Touch>,
    lost_frames: u64,
}

impl Engine {
    /// An engine for a pad, what its frames are read with, and a profile.
    ///
    /// # Panics
    /// If that is not of the pad.
    #[must_use]
    pub fn new(pad: &Pad, sensing: Arc<Sensing>, profile: Arc<Profile>) -> Self {
        assert_eq!(pad.channels(), sensing.channels());
        let pad_mm = pad.outline.size_mm();
        Self {
            detector: Detector::of_pad(sensing, &pad.protocol),
            gestures: Gestures::new(profile, pad_mm),
            changed: Vec::new(),
            lost_frames: 0,
        }
    }

    /// Moves contacts to where a calibration's presses have shown them to be.
    #[must_use]
    pub fn corrected(mut self, correction: Option<Correction>) -> Self {
        self.detector = self.detector.corrected(correction);
        self
    }

    /// Takes one input and appends the events that follow from it, in the order of their times.
    ///
    /// # Panics
    /// If a frame or matrix has another number of channels than the pad: sources check that.
    pub fn input(&mut self, input: &Input, events: &mut Vec<Event>) {
        self.input_watched(input, events, &mut || {});
    }

    /// The same, for who has a clock: calls `placed` once a frame's touches are known and before its events are made.
    ///
    /// # Panics
    /// See [`Engine::input`].
    pub fn input_watched(
        &mut self,
        input: &Input,
        events: &mut Vec<Event>,
        placed: &mut dyn FnMut(),
    ) {
        self.changed.clear();
        match input {
            Input::Frame(frame) => {
                self.detector.frame(frame, &mut self.changed);
                placed();
                self.gestures.touches(frame.t_ns, &self.changed, events);
            }
            Input::Control(control) => self.gestures.control(control, events),
            Input::Tick { due_ns } => self.gestures.tick(*due_ns, events),
            Input::Profile { t_ns, profile } => {
                self.gestures.replace(Arc::clone(profile), *t_ns, events);
            }
            Input::Pause { t_ns } => {
                self.gestures.tick(*t_ns, events);
                self.gestures
                    .pause(*t_ns, !self.gestures.is_paused(), events);
            }
            Input::Matrix(sensing) => self.detector.take(Arc::clone(sensing)),
            Input::Rezero { t_ns } => {
                self.detector.rezero(&mut self.changed);
                self.gestures.tick(*t_ns, events);
                self.gestures.touches(*t_ns, &self.changed, events);
            }
            Input::Lost { frames } => self.lost_frames += frames,
            Input::End { t_ns } => {
                self.detector.lift_all(&mut self.changed);
                self.gestures.tick(*t_ns, events);
                self.gestures.release_all(*t_ns, events);
            }
        }
    }

    /// When the engine wants a [`Input::Tick`], if it waits for one.
    #[must_use]
    pub fn next_due(&self) -> Option<Nanos> {
        self.gestures.next_due()
    }

    /// The last frame's image and the touches that are down.
    #[must_use]
    pub fn touches(&self) -> FrameTouches<'_> {
        self.detector.state()
    }

    /// What finds the touches, for views of its signals.
    #[must_use]
    pub fn detector(&self) -> &Detector {
        &self.detector
    }

    /// The outputs that are down.
    pub fn held(&self) -> impl Iterator<Item = Output> + '_ {
        self.gestures.held()
    }

    /// Whether the player has paused.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.gestures.is_paused()
    }

    /// The profile in force.
    #[must_use]
    pub fn profile(&self) -> &Arc<Profile> {
        self.gestures.profile()
    }

    /// The weights for which an [`Input::Matrix`] is wanted, if one is: see [`Detector::wanted`].
    #[must_use]
    pub fn wanted(&self) -> Option<&[f64]> {
        self.detector.wanted()
    }

    /// Electrodes that are left out, ascending, counted from 0.
    #[must_use]
    pub fn lost_electrodes(&self) -> Vec<usize> {
        self.detector.lost_electrodes()
    }

    /// Channels that the first frames showed to be dead or loose, and that are left out since.
    #[must_use]
    pub fn muted_channels(&self) -> Vec<usize> {
        self.detector.muted_channels()
    }

    /// How often the reference was taken anew, because a finger had lain on the pad while it was taken.
    #[must_use]
    pub fn references_retaken(&self) -> u64 {
        self.detector.retaken()
    }

    /// Frames that were lost before the engine.
    #[must_use]
    pub fn lost_frames(&self) -> u64 {
        self.lost_frames
    }
}
