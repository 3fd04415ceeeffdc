//! The stages in order: inputs in, events out. Pure and deterministic.
//!
//! Invariant: the same inputs in the same order give the same events, bit for bit, at any speed. Nothing here
//! reads a clock, starts a thread or does IO; time comes with the input.

use std::sync::Arc;

use crate::gesture::Gestures;
use crate::pad::{Numbering, Pad};
use crate::profile::Profile;
use crate::touch::{ChannelNoise, Correction, Detector, Scan, Sensing};
use crate::types::{Control, Event, Frame, Image, Nanos, Output, Part, Touch};

/// An input of the engine.
#[derive(Clone, Debug)]
pub enum Input {
    /// A frame with one voltage per channel of the pad.
    Frame(Frame),
    /// Readings of a frame that is still being read.
    Part(Part),
    /// The state of gamepads and switches: a source without image.
    Control(Control),
    /// A time returned by [`Engine::next_due`] has come.
    Tick {
        /// That time, never the time of the clock.
        due_ns: Nanos,
    },
    /// Switches to another profile as soon as no output is down; after one second, outputs are released.
    Profile {
        /// Time of the switch.
        t_ns: Nanos,
        /// The profile.
        profile: Arc<Profile>,
    },
    /// Pauses or resumes.
    Pause {
        /// Time.
        t_ns: Nanos,
    },
    /// Replaces matrix and channel weights of the pad, because an electrode was lost or recovered.
    Matrix(Arc<Sensing>),
    /// Takes the reference again: the pad counts as untouched as it is now. Outputs are released.
    Rezero {
        /// Time.
        t_ns: Nanos,
    },
    /// Frames were lost before they reached the engine.
    Lost {
        /// Number of frames.
        frames: u64,
    },
    /// The source ended or disconnected: outputs are released.
    End {
        /// Time.
        t_ns: Nanos,
    },
}

/// All stages and their state.
#[derive(Clone, Debug)]
pub struct Engine {
    detector: Detector,
    scan: Scan,
    gestures: Gestures,
    changed: Vec<Touch>,
    lost_frames: u64,
}

impl Engine {
    /// An engine for a pad, its sensing and a profile.
    ///
    /// # Panics
    /// If the sensing has another number of channels than the pad.
    #[must_use]
    pub fn new(pad: &Pad, sensing: Arc<Sensing>, profile: Arc<Profile>) -> Self {
        assert_eq!(pad.channels(), sensing.channels());
        let pad_mm = pad.outline.size_mm();
        Self {
            detector: Detector::for_pad(sensing, &pad.protocol),
            scan: Scan::default(),
            gestures: Gestures::new(profile, pad_mm),
            changed: Vec::new(),
            lost_frames: 0,
        }
    }

    /// Corrects the places of contacts by a calibration.
    #[must_use]
    pub fn with_correction(mut self, correction: Option<Correction>) -> Self {
        self.detector = self.detector.with_correction(correction);
        self
    }

    /// Processes one input and appends the events that follow from it, ordered by time.
    ///
    /// # Panics
    /// If a frame or matrix has another number of channels than the pad, which sources prevent.
    pub fn input(&mut self, input: &Input, events: &mut Vec<Event>) {
        self.input_with_callback(input, events, &mut || {});
    }

    /// Like [`Engine::input`], but calls `placed` when the touches of a frame are known, before its events are computed:
    /// for measuring time.
    ///
    /// # Panics
    /// See [`Engine::input`].
    pub fn input_with_callback(
        &mut self,
        input: &Input,
        events: &mut Vec<Event>,
        placed: &mut dyn FnMut(),
    ) {
        self.changed.clear();
        match input {
            Input::Frame(frame) => {
                self.scan
                    .process_frame(&mut self.detector, frame, &mut self.changed);
                placed();
                self.gestures.touches(frame.t_ns, &self.changed, events);
            }
            Input::Part(part) => {
                self.scan
                    .process_part(&mut self.detector, part, &mut self.changed);
                placed();
                self.gestures.touches(part.t_ns, &self.changed, events);
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
            Input::Matrix(sensing) => self.detector.set_sensing(Arc::clone(sensing)),
            Input::Rezero { t_ns } => {
                self.detector.rezero(&mut self.changed);
                self.scan.reset();
                self.gestures.tick(*t_ns, events);
                self.gestures.touches(*t_ns, &self.changed, events);
            }
            Input::Lost { frames } => self.lost_frames += frames,
            Input::End { t_ns } => {
                self.detector.lift_all(&mut self.changed);
                self.scan.reset();
                self.gestures.tick(*t_ns, events);
                self.gestures.release_all(*t_ns, events);
            }
        }
    }

    /// The time of the next [`Input::Tick`], if one is needed.
    #[must_use]
    pub fn next_due(&self) -> Option<Nanos> {
        self.gestures.next_due()
    }

    /// The touches that are down.
    #[must_use]
    pub fn touches_down(&self) -> &[Touch] {
        self.detector.touches_down()
    }

    /// The image of the last frame, drawn when it is asked for; blank until the reference is taken.
    pub fn image(&mut self) -> &Image {
        self.detector.image()
    }

    /// The detector, for views of its signals.
    #[must_use]
    pub fn detector(&self) -> &Detector {
        &self.detector
    }

    /// The outputs that are down.
    pub fn held_outputs(&self) -> impl Iterator<Item = Output> + '_ {
        self.gestures.held()
    }

    /// Whether the engine is paused.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.gestures.is_paused()
    }

    /// The active profile.
    #[must_use]
    pub fn profile(&self) -> &Arc<Profile> {
        self.gestures.profile()
    }

    /// The deviations for which an [`Input::Matrix`] is wanted, if one is; see [`Detector::wanted`].
    #[must_use]
    pub fn wanted(&self) -> Option<&ChannelNoise> {
        self.detector.wanted()
    }

    /// Lost electrodes, ascending, counted from 0.
    #[must_use]
    pub fn lost_electrodes(&self) -> Vec<usize> {
        self.detector.lost_electrodes()
    }

    /// Muted channels: dead, loose or of a lost electrode.
    #[must_use]
    pub fn muted_channels(&self) -> Vec<usize> {
        self.detector.muted_channels()
    }

    /// How often the reference was taken again, because it had been taken under a finger or a palm.
    #[must_use]
    pub fn references_retaken(&self) -> u64 {
        self.detector.references_retaken()
    }

    /// How many times the board has hung: touches were lifted because it repeated one frame.
    #[must_use]
    pub fn hangs(&self) -> u64 {
        self.detector.hangs()
    }

    /// From where the board counts the electrodes, relative to the start, and how often that changed: it was plugged in again,
    /// turned or mirrored.
    #[must_use]
    pub fn board_numbering(&self) -> (Numbering, u64) {
        self.detector.board_numbering()
    }

    /// Number of frames lost before they reached the engine.
    #[must_use]
    pub fn lost_frames(&self) -> u64 {
        self.lost_frames
    }
}
