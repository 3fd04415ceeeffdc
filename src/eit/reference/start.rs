//! The first frames of a reference: its levels, the noise of each channel, and the channels that are dead, loose or below
//! the noise.

use super::{LEAST_NOISE, Reference};
use crate::eit::noise::NoiseModel;

/// Least share of the noise of the first frames that is the channel's own, whatever channels share.
const LEAST_OWN_SHARE: f64 = 0.01;
/// A channel is loose if its first readings spread this many times as widely as expected.
const LOOSE_SPREAD: f64 = 20.0;
/// A channel is below the noise if the noise expected of its reading exceeds this share of it: a relative change of it may be anything.
const BELOW_NOISE: f64 = 0.3;

impl Reference {
    /// Adds one of the first frames to the mean.
    pub fn add_first_frame(&mut self, t_ns: u64, volts: &[f32]) {
        self.frames += 1;
        let share = 1.0 / self.frames as f64;
        for ((level, square), volt) in self.volts.iter_mut().zip(&mut self.squares).zip(volts) {
            let volt = f64::from(*volt);
            *level += share * (volt - *level);
            *square += volt * volt;
        }
        self.last_ns = t_ns;
        if self.is_ready() {
            self.measure_first_frames();
            for (covariance, noise) in self.covariances.iter_mut().zip(&self.noise) {
                covariance.level = noise / self.frames as f64;
            }
        }
    }

    /// Estimates from the first frames the noise that channels share, and removes it from their own.
    pub fn learn_first_shared_noise(&mut self, frames: &[(u64, Vec<f32>)]) {
        let untouched = vec![0.0; self.volts.len()];
        for (_, volts) in frames {
            self.learn_shared_noise(volts, &untouched);
        }
        let shared = self.shared_noise();
        for noise in &mut self.noise {
            let own = *noise - shared.gain - shared.drive;
            *noise = own
                .max(LEAST_OWN_SHARE * *noise)
                .max(LEAST_NOISE * LEAST_NOISE);
        }
    }

    /// Estimates the noise from the spread of the first frames and mutes channels that are dead, loose or below the noise.
    fn measure_first_frames(&mut self) {
        let rounding = self.step * self.step / 12.0;
        let count = self.frames as f64;
        let variances: Vec<f64> = self
            .volts
            .iter()
            .zip(&self.squares)
            .map(|(mean, square)| (square - count * mean * mean).max(0.0) / (count - 1.0))
            .collect();
        let noise = NoiseModel::from_variances(&self.volts, &variances);
        for (channel, variance) in variances.iter().enumerate() {
            let square = self.volts[channel] * self.volts[channel];
            let expected = noise
                .variance(square)
                .max(LEAST_NOISE * LEAST_NOISE * square);
            self.rounding[channel] = if square == 0.0 {
                0.0
            } else {
                rounding / square
            };
            self.muted[channel] = square == 0.0
                || expected > BELOW_NOISE * BELOW_NOISE * square
                || *variance > LOOSE_SPREAD * LOOSE_SPREAD * (expected + rounding);
            self.noise[channel] = if square == 0.0 {
                1.0
            } else {
                expected / square
            };
        }
    }
}
