//! A robot that presses the simulated pad at given places, one after the other.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use super::{Finger, Noise, Pace, Reading, SimulatedPad, Source, SourceError};
use crate::pad::Pad;
use crate::types::{Frame, NANOS_PER_MS, Nanos, PointMm};

/// 100 frames a second.
const FRAME_NS: Nanos = 10 * NANOS_PER_MS;
/// Frames for which it waits before each press, and for which it presses.
const FRAMES: (u64, u64) = (30, 30);
/// How far it misses a place, deviation a coordinate, mm.
const MISS_MM: f64 = 0.3;
/// Its finger: radius, mm, and relative rise of conductivity, with the share by which presses differ.
const FINGER: (f64, f64, f64) = (7.0, 1.2, 0.2);

/// The robot as a source; it ends when the last place is pressed.
pub struct Robot {
    pad: SimulatedPad,
    places: std::vec::IntoIter<PointMm>,
    rest: Vec<f64>,
    pressed: Option<Vec<f64>>,
    /// Frames of this place so far.
    frame: u64,
    next_ns: Nanos,
    noise: Noise,
    random: ChaCha8Rng,
}

impl Robot {
    /// A robot for a pad and places on it.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    pub fn new(
        pad: &Pad,
        places: Vec<PointMm>,
        noise: Noise,
        seed: u64,
    ) -> Result<Self, SourceError> {
        let pad = SimulatedPad::new(pad)?;
        Ok(Self {
            rest: pad.volts(&[])?,
            pad,
            places: places.into_iter(),
            pressed: None,
            frame: 0,
            next_ns: 0,
            noise,
            random: ChaCha8Rng::seed_from_u64(seed),
        })
    }

    fn press(&mut self, place_mm: PointMm) -> Result<Vec<f64>, SourceError> {
        let [dx, dy, dr] = [0; 3].map(|_| -> f64 { StandardNormal.sample(&mut self.random) });
        let (radius_mm, rise, vary) = FINGER;
        let finger = Finger {
            id: 1,
            centre_mm: [place_mm[0] + MISS_MM * dx, place_mm[1] + MISS_MM * dy],
            radius_mm,
            rise: rise * libm::exp(vary * dr),
        };
        Ok(self.pad.volts(&[finger])?)
    }
}

impl Source for Robot {
    fn pace(&self) -> Pace {
        Pace::ByStamp
    }

    fn read(&mut self) -> Result<Reading, SourceError> {
        if self.frame == FRAMES.0 + FRAMES.1 {
            self.frame = 0;
            self.pressed = None;
        }
        if self.frame == FRAMES.0 {
            match self.places.next() {
                Some(place) => self.pressed = Some(self.press(place)?),
                None => return Ok(Reading::End),
            }
        }
        self.frame += 1;
        let t_ns = self.next_ns;
        self.next_ns += FRAME_NS;
        Ok(Reading::Frame(Frame {
            t_ns,
            volts: self.noise.read(self.pressed.as_ref().unwrap_or(&self.rest)),
        }))
    }
}
