//! Noise on simulated readings.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;

use crate::stats::range;

/// What the noise of a reading is proportional to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseKind {
    /// The reading itself: an amplifier with a range for each channel.
    Proportional,
    /// The largest reading of the untouched pad: one range for all channels.
    FullScale,
}

impl NoiseKind {
    /// Both, in the order of reports.
    pub const ALL: [Self; 2] = [Self::Proportional, Self::FullScale];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Proportional => "proportional",
            Self::FullScale => "full-scale",
        }
    }

    /// The standard deviation of each reading at 0 dB, V/A.
    pub(super) fn deviations(self, volts: &[f64], rest: &[f64]) -> Vec<f64> {
        match self {
            Self::Proportional => volts.iter().map(|volt| volt.abs()).collect(),
            Self::FullScale => {
                let [_, largest] = range(rest.iter().map(|volt| volt.abs()));
                vec![largest; volts.len()]
            }
        }
    }
}

/// Standard deviation at an SNR, as a share of that at 0 dB.
pub(super) fn share(snr_db: f64) -> f64 {
    libm::pow(10.0, -snr_db / 20.0)
}

/// Adds noise to readings. The seed alone determines the noise: another SNR only scales it, so that the results at one SNR do
/// not depend on which others are studied.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instrument<'a> {
    pub kind: NoiseKind,
    pub snr_db: f64,
    /// Readings of the untouched pad, V/A.
    pub rest: &'a [f64],
}

impl Instrument<'_> {
    /// `count` frames of one state.
    pub(super) fn frames(&self, volts: &[f64], seed: u64, count: usize) -> Vec<Vec<f32>> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let share = share(self.snr_db);
        let deviations = self.kind.deviations(volts, self.rest);
        (0..count)
            .map(|_| {
                volts
                    .iter()
                    .zip(&deviations)
                    .map(|(volt, deviation)| {
                        let n: f64 = StandardNormal.sample(&mut random);
                        (volt + share * deviation * n) as f32
                    })
                    .collect()
            })
            .collect()
    }

    /// One frame.
    pub(super) fn frame(&self, volts: &[f64], seed: u64) -> Vec<f32> {
        self.frames(volts, seed, 1).swap_remove(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_its_size_and_only_scales_with_the_snr() {
        let rest: Vec<f64> = (1..=4000).map(|i| f64::from(i % 10 + 1)).collect();
        let frame = |kind, snr_db| {
            let rest = rest.as_slice();
            Instrument { kind, snr_db, rest }.frame(rest, 5)
        };
        for (kind, size) in [(NoiseKind::Proportional, 1.0), (NoiseKind::FullScale, 10.0)] {
            // On the channels that read 1 the two differ by the full scale of 10.
            let off = |snr_db| -> Vec<f64> {
                let read = frame(kind, snr_db);
                (9..4000)
                    .step_by(10)
                    .map(|channel| f64::from(read[channel]) - 1.0)
                    .collect()
            };
            let (at_40, at_60) = (off(40.0), off(60.0));
            let rms = (at_40.iter().map(|n| n * n).sum::<f64>() / 400.0).sqrt();
            assert!((rms / (0.01 * size) - 1.0).abs() < 0.12, "{rms}");
            for (a, b) in at_40.iter().zip(at_60) {
                assert!((a - 10.0 * b).abs() < 1e-5);
            }
        }
    }
}
