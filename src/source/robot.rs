//! A simulated robot that presses the simulated pad at given places, one after the other.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use super::simulated::{FINGER_RADIUS_MM, FINGER_RISE, SIMULATED_FRAME_NS};
use super::{Noise, SimulatedPad, Source, SourceError, SourcePace, SourceReading};
use crate::eit::Press;
use crate::pad::Pad;
use crate::types::{Frame, Nanos, PointMm};

/// Number of frames without a press before each press, and number of frames of a press.
const REST_AND_PRESS_FRAMES: (u64, u64) = (30, 30);
/// Standard deviation of the placing error for each coordinate, mm.
const PLACING_ERROR_MM: f64 = 0.3;
/// Standard deviation of the logarithm of the rise from press to press.
const RISE_SPREAD: f64 = 0.2;

/// The robot as a source; it ends after the last place.
pub struct RobotSource {
    pad: SimulatedPad,
    places: std::vec::IntoIter<PointMm>,
    rest: Vec<f64>,
    pressed: Option<Vec<f64>>,
    /// Number of frames at this place so far.
    frame: u64,
    next_ns: Nanos,
    noise: Noise,
    random: ChaCha8Rng,
}

impl RobotSource {
    /// A robot for a pad and places on it.
    ///
    /// # Errors
    /// The pad cannot be solved.
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
        let press = Press {
            centre_mm: [
                place_mm[0] + PLACING_ERROR_MM * dx,
                place_mm[1] + PLACING_ERROR_MM * dy,
            ],
            radius_mm: FINGER_RADIUS_MM,
            rise: FINGER_RISE * libm::exp(RISE_SPREAD * dr),
        };
        Ok(self.pad.volts(&[press])?)
    }
}

impl Source for RobotSource {
    fn pace(&self) -> SourcePace {
        SourcePace::ByStamp
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        if self.frame == REST_AND_PRESS_FRAMES.0 + REST_AND_PRESS_FRAMES.1 {
            self.frame = 0;
            self.pressed = None;
        }
        if self.frame == REST_AND_PRESS_FRAMES.0 {
            match self.places.next() {
                Some(place) => self.pressed = Some(self.press(place)?),
                None => return Ok(SourceReading::End),
            }
        }
        self.frame += 1;
        let t_ns = self.next_ns;
        self.next_ns += SIMULATED_FRAME_NS;
        Ok(SourceReading::Frame(Frame {
            t_ns,
            volts: self.noise.read(self.pressed.as_ref().unwrap_or(&self.rest)),
        }))
    }
}
