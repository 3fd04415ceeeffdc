//! Measurement noise, proportional to each channel, from a seed.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Multiplies readings by 1 + 10^(-SNR/20) n with n ~ N(0, 1). The same seed gives the same noise.
#[derive(Clone, Debug)]
pub struct Noise {
    deviation: f64,
    random: ChaCha8Rng,
}

impl Noise {
    /// Noise with a signal-to-noise ratio in dB.
    #[must_use]
    pub fn new(snr_db: f64, seed: u64) -> Self {
        Self {
            deviation: libm::pow(10.0, -snr_db / 20.0),
            random: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// One noisy reading of each value.
    pub fn read(&mut self, values: &[f64]) -> Vec<f32> {
        values
            .iter()
            .map(|value| {
                let n: f64 = StandardNormal.sample(&mut self.random);
                (value * (1.0 + self.deviation * n)) as f32
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixty_db_is_a_thousandth() {
        let values = vec![2.0; 10_000];
        let noisy = Noise::new(60.0, 1).read(&values);
        let power: f64 = noisy
            .iter()
            .map(|v| (f64::from(*v) / 2.0 - 1.0).powi(2))
            .sum();
        let deviation = (power / 1e4).sqrt();
        assert!((deviation / 1e-3 - 1.0).abs() < 0.05, "{deviation}");
        assert_eq!(noisy, Noise::new(60.0, 1).read(&values));
        assert_ne!(noisy, Noise::new(60.0, 2).read(&values));
    }
}
