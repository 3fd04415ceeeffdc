//! A board that reads a pad, and the sensing of play behind it.

use std::sync::Arc;

use super::Condition;
use crate::pad::Protocol;
use crate::source::{Disturber, Noise};
use crate::touch::{ChannelNoise, Detector, SensingBuilder};
use crate::types::{Frame, NANOS_PER_MS, Nanos, Touch};

/// A hundred frames a second, as in play.
pub(super) const FRAME_NS: Nanos = 10 * NANOS_PER_MS;

/// Reads a pad, with the noise and the disturbances of a condition.
pub(super) struct Board {
    noise: Noise,
    disturber: Disturber,
    frames: usize,
}

impl Board {
    /// A board before its first frame. `rest` are the readings of the untouched pad, V/A.
    pub(super) fn new(condition: &Condition, rest: &[f64], protocol: &Protocol, seed: u64) -> Self {
        Self {
            noise: Noise::new(condition.snr_db, seed),
            disturber: Disturber::new(&condition.disturbances, rest, protocol, seed ^ 0x5eed),
            frames: 0,
        }
    }

    /// Time since the first frame, s: that of the next one.
    pub(super) fn now_s(&self) -> f64 {
        self.frames as f64 * FRAME_NS as f64 * 1e-9
    }

    /// The next frame of a pad with these readings, V/A.
    pub(super) fn read(&mut self, volts: &[f64]) -> Frame {
        let read = self.noise.read(volts);
        let mut read: Vec<f64> = read.into_iter().map(f64::from).collect();
        self.disturber.apply(self.now_s(), &mut read);
        let t_ns = self.frames as Nanos * FRAME_NS;
        self.frames += 1;
        Frame {
            t_ns,
            volts: read.into_iter().map(|volt| volt as f32).collect(),
        }
    }
}

/// The detector of play, which gets the weights that it asks for.
pub(super) struct Sensed<'a> {
    pub(super) detector: Detector,
    builder: &'a SensingBuilder,
    /// The noise of its present weights; `None` for the first ones.
    noise: Option<ChannelNoise>,
    changed: Vec<Touch>,
}

impl<'a> Sensed<'a> {
    pub(super) fn new(detector: Detector, builder: &'a SensingBuilder) -> Self {
        Self {
            detector,
            builder,
            noise: None,
            changed: Vec::new(),
        }
    }

    pub(super) fn process(&mut self, frame: &Frame) {
        self.changed.clear();
        self.detector.process_frame(frame, &mut self.changed);
        if let Some(wanted) = self.detector.wanted() {
            self.noise = Some(wanted.clone());
            self.rebuild();
        }
    }

    /// Channels that the detector leaves out, as those of a lost electrode.
    pub(super) fn left_out(&self) -> Vec<usize> {
        let sensing = self.detector.sensing();
        let channels = 0..sensing.channels();
        channels.filter(|c| !sensing.uses_channel(*c)).collect()
    }

    /// Locates touches on another pad from now on.
    pub(super) fn change_pad(&mut self, builder: &'a SensingBuilder) {
        self.builder = builder;
        self.rebuild();
    }

    /// As in play: where no weights can be made, the present ones stay.
    fn rebuild(&mut self) {
        let built = match &self.noise {
            Some(noise) => self.builder.build(noise),
            None => self.builder.build_initial(),
        };
        if let Ok(sensing) = built {
            self.detector.set_sensing(Arc::new(sensing));
        }
    }
}
