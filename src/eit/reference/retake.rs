//! The level taken again from a few frames, with the noise that is known: when a finger that lay on the pad has lifted.

use super::{Covariance, FIRST_COMMON_RATE_PER_S, FIRST_RATE_PER_S, Reference, SETTLE_FRAMES};
use crate::eit::median;

/// Variance of the median of few readings as a multiple of that of their mean.
const MEDIAN_VARIANCE: f64 = 1.5;
/// Readings of two frames differ by at most this many standard deviations of their noise.
const MOST_DEVIATIONS: f64 = 8.0;

impl Reference {
    /// Whether the last two of some frames (time in ns, volts) differ by no more than the noise of the channels, as those of a board do on
    /// which no wire is loose.
    #[must_use]
    pub fn differ_by_noise_only(&self, frames: &[(u64, Vec<f32>)]) -> bool {
        let [.., (_, before), (_, last)] = frames else {
            return false;
        };
        let limit = MOST_DEVIATIONS * MOST_DEVIATIONS;
        self.squares_between(before, last)
            .all(|square| square <= limit)
    }

    /// How far two frames (volts) are apart: the median of the channels' squared differences in units of their variance. 0.45 for noise.
    #[must_use]
    pub fn apart(&self, before: &[f32], now: &[f32]) -> f64 {
        let mut squares: Vec<f64> = self.squares_between(before, now).collect();
        median(&mut squares).unwrap_or(0.0)
    }

    /// Squared differences between two frames of the channels in use, in units of the variance of a difference.
    fn squares_between<'a>(
        &'a self,
        before: &'a [f32],
        now: &'a [f32],
    ) -> impl Iterator<Item = f64> + 'a {
        let shared = self.shared_noise();
        (0..self.volts.len())
            .filter(|c| self.is_live(*c))
            .map(move |channel| {
                let change = f64::from(now[channel] - before[channel]) / self.volts[channel];
                let own = self.noise[channel] + self.rounding[channel];
                change * change / (2.0 * (own + shared.gain + shared.drive))
            })
    }

    /// Takes the level again as the median of a few frames of the untouched pad (time in ns, volts), of which one may be odd. The noise of
    /// the channels stays as it was learned, and so do the levels of muted ones.
    pub fn retake_level(&mut self, frames: &[(u64, Vec<f32>)]) {
        let shared = self.shared_noise();
        let mut volts = Vec::with_capacity(frames.len());
        for channel in 0..self.volts.len() {
            // A loose wire reads anything.
            if self.muted[channel] {
                continue;
            }
            volts.clear();
            let readings = frames.iter().map(|(_, volts)| f64::from(volts[channel]));
            volts.extend(readings.filter(|volt| volt.is_finite()));
            let Some(level) = median(&mut volts) else {
                continue;
            };
            self.volts[channel] = level;
            self.rates[channel] = 0.0;
            let covariance = &mut self.covariances[channel];
            *covariance = Covariance::from_rate(FIRST_RATE_PER_S);
            let noise = self.noise[channel] + shared.drive;
            covariance.level = MEDIAN_VARIANCE * noise / volts.len() as f64;
        }
        self.common = Covariance::from_rate(FIRST_COMMON_RATE_PER_S);
        self.common.level = MEDIAN_VARIANCE * shared.gain / frames.len().max(1) as f64;
        self.quiet_frames = SETTLE_FRAMES;
        self.last_ns = frames.last().map_or(self.last_ns, |(t_ns, _)| *t_ns);
    }
}
