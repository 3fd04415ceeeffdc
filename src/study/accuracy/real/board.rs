//! A board that reads a pad.

use super::Condition;
use crate::pad::Protocol;
use crate::source::{Disturber, Noise};
use crate::study::accuracy::sensed::FRAME_NS;
use crate::types::{Frame, Nanos};

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
