//! The reference: the present readings of the untouched pad.
//!
//! Gels dry, warm and creep: each channel drifts at a nearly constant rate, some percent per minute. So the reference is a
//! level and a rate per channel, estimated by a Kalman filter (`kalman`) from channels that no touch changes. Under a touch,
//! a channel continues along its rate while its uncertainty grows: a held press does not fade, and drift during a long hold
//! is predicted instead of taken for a touch.
//!
//! A touch in one corner does not change channels far away. These are still measured, and their common drift corrects the
//! others. The noise of each channel is estimated along the way.

mod retake;
mod start;

use super::kalman::Covariance;
use super::noise::NoiseModel;
use super::shared_noise::{SharedNoise, SharedNoiseEstimator};

/// The first reference is the mean of this many frames.
pub const REFERENCE_FRAMES: usize = 10;

/// Standard deviation of the initial drift, share per second: 3 % per minute.
const FIRST_RATE_PER_S: f64 = 5e-4;
/// Standard deviation of the initial drift common to all channels, share per second: 12 % per minute.
const FIRST_COMMON_RATE_PER_S: f64 = 2e-3;
/// Lower bound of the noise, as a share: 100 dB.
const LEAST_NOISE: f64 = 1e-5;
/// Longest step of time: a source that paused must not carry the reference far along its rate.
const LONGEST_STEP_S: f64 = 0.2;
/// Frames after a touch in which the gel springs back and the reference is not updated.
const SETTLE_FRAMES: u32 = 3;
/// Weight of a frame in the running estimate of a channel's noise: a time constant of some seconds.
const NOISE_WEIGHT: f64 = 0.004;
/// Time constant, s, with which the rate of a channel under a touch decays: it may have been measured only briefly.
const UNSEEN_RATE_S: f64 = 10.0;
/// A channel is measured if the touches change it by less than this many standard deviations.
const FREE_DEVIATIONS: f64 = 1.0;
/// Relative error of the change that touches explain.
const TOUCH_ERROR: f64 = 0.1;

/// The voltages of the untouched pad, tracked over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    volts: Vec<f64>,
    /// Volts per second.
    rates: Vec<f64>,
    covariances: Vec<Covariance>,
    /// Covariance of the gain common to all channels.
    common: Covariance,
    /// Relative variance of the readings of each channel, without the noise that channels share.
    noise: Vec<f64>,
    /// Step of the board's converter, V; 0 if the readings show none.
    step: f64,
    /// Relative variance of rounding of each channel, which no repetition averages out.
    rounding: Vec<f64>,
    /// Noise that channels share; `None` if their drives are unknown.
    shared: Option<SharedNoiseEstimator>,
    /// Sums of squares of the first frames' volts.
    squares: Vec<f64>,
    /// Excluded channels.
    muted: Vec<bool>,
    frames: usize,
    quiet_frames: u32,
    last_ns: u64,
    /// Time of the last frame from which [`Self::take_out_gains`] learned.
    gains_learned_ns: Option<u64>,
    /// Factor of the last time step for the rate of a channel under a touch.
    unseen_keep: f64,
}

impl Reference {
    /// A reference before its first frame.
    #[must_use]
    pub fn new(channels: usize) -> Self {
        Self {
            volts: vec![0.0; channels],
            rates: vec![0.0; channels],
            covariances: vec![Covariance::from_rate(FIRST_RATE_PER_S); channels],
            common: Covariance::from_rate(FIRST_COMMON_RATE_PER_S),
            noise: vec![LEAST_NOISE * LEAST_NOISE; channels],
            step: 0.0,
            rounding: vec![0.0; channels],
            shared: None,
            squares: vec![0.0; channels],
            muted: vec![false; channels],
            frames: 0,
            quiet_frames: SETTLE_FRAMES,
            last_ns: 0,
            gains_learned_ns: None,
            unseen_keep: 1.0,
        }
    }

    /// Also estimates the noise that channels share; `drives` is the drive of each channel, counted from 0.
    #[must_use]
    pub fn with_drives(mut self, drives: Vec<u16>) -> Self {
        self.shared = Some(SharedNoiseEstimator::new(drives));
        self
    }

    /// Sets the step of the board's converter, V.
    pub fn set_step(&mut self, step: Option<f64>) {
        self.step = step.unwrap_or(0.0);
    }

    /// Whether the readings show the steps of the board's converter.
    #[must_use]
    pub fn is_rounded(&self) -> bool {
        self.step > 0.0
    }

    /// Variances of the gains that channels share; 0 where the frames show none.
    #[must_use]
    pub fn shared_noise(&self) -> SharedNoise {
        let estimator = self.shared.as_ref();
        estimator
            .map(SharedNoiseEstimator::estimate)
            .unwrap_or_default()
    }

    /// Whether all first frames are in; only then are changes meaningful.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.frames >= REFERENCE_FRAMES
    }

    /// The voltages of the untouched pad, in the instrument's units.
    #[must_use]
    pub fn volts(&self) -> &[f64] {
        &self.volts
    }

    /// Variances of a channel's relative change: the noise of the reading, and the uncertainty of the reference.
    #[must_use]
    pub fn variances(&self, channel: usize) -> [f64; 2] {
        let doubt = self.covariances[channel].level + self.common.level + self.rounding[channel];
        [self.noise[channel], doubt]
    }

    /// Mean variance of a relative change over the channels in use: noise plus uncertainty of the reference.
    #[must_use]
    pub fn change_variance(&self) -> f64 {
        self.mean(|channel| self.noise[channel] + self.covariances[channel].level)
            + self.common.level
    }

    /// Standard deviation of a relative change; see [`Self::change_variance`].
    #[must_use]
    pub fn change_noise(&self) -> f64 {
        libm::sqrt(self.change_variance())
    }

    /// Factor by which the reference's uncertainty increases the noise of a change; 1 if it is certain.
    #[must_use]
    pub fn doubt(&self) -> f64 {
        libm::sqrt(self.change_variance() / self.mean(|channel| self.noise[channel]))
    }

    /// Relative standard deviation of each channel's readings; infinite for a muted channel.
    #[must_use]
    pub fn deviations(&self) -> Vec<f64> {
        self.noise
            .iter()
            .zip(&self.rounding)
            .zip(&self.muted)
            .map(|((noise, rounding), muted)| {
                if *muted {
                    f64::INFINITY
                } else {
                    libm::sqrt(noise + rounding)
                }
            })
            .collect()
    }

    /// Multiplies all levels: the gain of the board has changed.
    pub fn scale(&mut self, factor: f64) {
        for (volt, rate) in self.volts.iter_mut().zip(&mut self.rates) {
            *volt *= factor;
            *rate *= factor;
        }
    }

    /// Takes gains that channels share out of the relative changes of a frame, if they explain all but noise of what the touches of the
    /// frame before leave: a source that begins to waver, before that is known. `touched` is what those touches change. With
    /// `is_learned`, how much the gains vary is learned at once.
    pub fn take_out_gains(&mut self, touched: &[f32], changes: &mut [f32], is_learned: bool) {
        let Some(mut estimator) = self.shared.take() else {
            return;
        };
        let residual = |channel: usize| {
            let change = f64::from(changes[channel] - touched[channel]);
            self.is_live(channel)
                .then(|| (change, self.own_variance(channel, touched[channel])))
        };
        if estimator.explains_frame(residual, is_learned) {
            for (channel, change) in changes.iter_mut().enumerate() {
                if self.is_live(channel) {
                    *change -= estimator.explaining_gain(channel) as f32;
                }
            }
            if is_learned {
                self.gains_learned_ns = Some(self.last_ns);
            }
        }
        self.shared = Some(estimator);
    }

    /// Multiplies each level by 1 + a relative change: the pad has deformed. `changes` are those of a frame, and become relative to the new
    /// levels.
    pub fn shift(&mut self, by: &[f32], changes: &mut [f32]) {
        for (channel, (by, change)) in by.iter().zip(changes).enumerate() {
            let factor = 1.0 + f64::from(*by);
            self.volts[channel] *= factor;
            if self.is_live(channel) {
                *change = ((1.0 + f64::from(*change)) / factor - 1.0) as f32;
            }
        }
    }

    /// Predicts the reference at a time: levels move along their rates, uncertainties grow.
    pub fn advance(&mut self, t_ns: u64) {
        let elapsed_s = (t_ns.saturating_sub(self.last_ns) as f64 * 1e-9).min(LONGEST_STEP_S);
        self.last_ns = t_ns;
        self.unseen_keep = libm::exp(-elapsed_s / UNSEEN_RATE_S);
        for (level, rate) in self.volts.iter_mut().zip(&self.rates) {
            *level += rate * elapsed_s;
        }
        self.common.advance(elapsed_s);
        for covariance in &mut self.covariances {
            covariance.advance(elapsed_s);
        }
    }

    /// Updates the reference with a frame at the time of the last [`Self::advance`]. `volts` are the frame without its
    /// touches, `touched` the relative change of each channel by the touches. A gain common to all channels corrects every
    /// channel; channels that touches do not change are then measured one by one.
    pub fn update(&mut self, volts: &[f32], touched: &[f32]) {
        self.quiet_frames += 1;
        if self.quiet_frames <= SETTLE_FRAMES {
            return;
        }
        self.measure_common(volts, touched);
        if self.gains_learned_ns != Some(self.last_ns) {
            self.learn_shared_noise(volts, touched);
        }
        for (channel, (volt, touched)) in volts.iter().zip(touched).enumerate() {
            if !self.is_live(channel) {
                continue;
            }
            let touched = f64::from(*touched);
            let limit = FREE_DEVIATIONS * FREE_DEVIATIONS * self.noise[channel];
            if touched * touched < limit {
                self.measure(channel, f64::from(*volt));
            } else {
                self.rates[channel] *= self.unseen_keep;
                self.covariances[channel].shrink_rate(self.unseen_keep);
            }
        }
    }

    /// Measures the gain common to all channels and corrects them by it.
    fn measure_common(&mut self, volts: &[f32], touched: &[f32]) {
        let (mut surprise, mut weights) = (0.0, 0.0);
        for (channel, (volt, touched)) in volts.iter().zip(touched).enumerate() {
            if !self.is_live(channel) {
                continue;
            }
            let weight = 1.0 / self.own_variance(channel, *touched);
            surprise += weight * (f64::from(*volt) / self.volts[channel] - 1.0);
            weights += weight;
        }
        if weights == 0.0 {
            return;
        }
        let variance = 1.0 / weights + self.shared_noise().of_mean();
        let (level_by, rate_by) = self.common.measure(surprise / weights, variance);
        for (volt, rate) in self.volts.iter_mut().zip(&mut self.rates) {
            *volt += level_by * *volt;
            *rate += rate_by * *volt;
        }
    }

    /// Updates the estimate of the noise that channels share.
    fn learn_shared_noise(&mut self, volts: &[f32], touched: &[f32]) {
        let Some(mut shared) = self.shared.take() else {
            return;
        };
        shared.take_frame(|channel| {
            if !self.is_live(channel) {
                return None;
            }
            let change = f64::from(volts[channel]) / self.volts[channel] - 1.0;
            Some((change, self.own_variance(channel, touched[channel])))
        });
        self.shared = Some(shared);
    }

    /// Variance of a channel's change beside what channels share: large under a touch, and for a reading of a few steps of the
    /// converter, which stays where it is while the others drift.
    fn own_variance(&self, channel: usize, touched: f32) -> f64 {
        let error = TOUCH_ERROR * f64::from(touched);
        let own = self.noise[channel] + self.rounding[channel] + self.covariances[channel].level;
        own + error * error
    }

    fn is_live(&self, channel: usize) -> bool {
        !self.muted[channel] && self.volts[channel] != 0.0
    }

    /// Measures one channel.
    fn measure(&mut self, channel: usize, volt: f64) {
        let reference = self.volts[channel];
        let shared = self.shared.as_ref();
        let gain = shared.map_or(0.0, |shared| shared.gain_of(channel));
        let surprise = volt / reference - 1.0 - gain;
        let level = self.covariances[channel].level;
        let (level_by, rate_by) = self.covariances[channel].measure(surprise, self.noise[channel]);
        self.volts[channel] += level_by * reference;
        self.rates[channel] += rate_by * reference;
        self.update_noise(channel, surprise * surprise - level);
    }

    /// Skips a frame of a touched pad.
    pub fn skip_frame(&mut self) {
        self.quiet_frames = 0;
    }

    /// Mutes a channel, or takes it back with its level corrected by a relative change.
    pub fn mute(&mut self, channel: usize, muted: bool, corrected_by: f64) {
        self.muted[channel] = muted;
        self.volts[channel] *= 1.0 + corrected_by;
    }

    /// Relative variance of the readings of a channel: its own noise, that which channels share, and rounding.
    #[must_use]
    pub fn reading_variance(&self, channel: usize) -> f64 {
        let shared = self.shared_noise();
        self.noise[channel] + self.rounding[channel] + shared.gain + shared.drive
    }

    /// Takes a muted channel back at a level, V, as one of which nothing was known before: its noise is expected to be that of the others.
    /// `touched` is the relative change by touches that was removed from the level. A level of zero is none: the channel stays muted.
    pub fn reconnect(&mut self, channel: usize, volt: f64, touched: f32) {
        let square = volt * volt;
        if !square.is_normal() {
            return;
        }
        let live = (0..self.volts.len()).filter(|other| self.is_live(*other));
        let (volts, variances): (Vec<f64>, Vec<f64>) = live
            .map(|other| {
                let volt = self.volts[other];
                (volt, self.noise[other] * volt * volt)
            })
            .unzip();
        let noise = NoiseModel::from_variances(&volts, &variances).variance(square) / square;
        let noise = noise.max(LEAST_NOISE * LEAST_NOISE);
        self.muted[channel] = false;
        self.volts[channel] = volt;
        self.rates[channel] = 0.0;
        self.noise[channel] = noise;
        self.rounding[channel] = self.step * self.step / 12.0 / square;
        let error = TOUCH_ERROR * f64::from(touched);
        let covariance = &mut self.covariances[channel];
        *covariance = Covariance::from_rate(FIRST_RATE_PER_S);
        covariance.level = noise / REFERENCE_FRAMES as f64 + error * error;
    }

    /// Whether a channel is muted.
    #[must_use]
    pub fn is_muted(&self, channel: usize) -> bool {
        self.muted[channel]
    }

    /// Muted channels, ascending; their change is always 0.
    #[must_use]
    pub fn muted_channels(&self) -> Vec<usize> {
        (0..self.muted.len())
            .filter(|channel| self.muted[*channel])
            .collect()
    }

    /// Updates the estimate of a channel's noise.
    fn update_noise(&mut self, channel: usize, square: f64) {
        let noise = &mut self.noise[channel];
        // Limited, because one outlier is not a noise level.
        let square = square.clamp(0.0, 10.0 * *noise);
        *noise = (*noise + NOISE_WEIGHT * (square - *noise)).max(LEAST_NOISE * LEAST_NOISE);
    }

    /// Mean over the channels in use.
    fn mean(&self, value: impl Fn(usize) -> f64) -> f64 {
        let (mut count, mut sum) = (0usize, 0.0);
        for channel in (0..self.muted.len()).filter(|channel| !self.muted[*channel]) {
            count += 1;
            sum += value(channel);
        }
        if count == 0 {
            LEAST_NOISE * LEAST_NOISE
        } else {
            sum / count as f64
        }
    }

    /// Relative changes (v - v0) / v0; 0 for a muted channel.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn relative_changes(&self, volts: &[f32], changes: &mut [f32]) {
        assert_eq!(volts.len(), self.volts.len());
        assert_eq!(changes.len(), self.volts.len());
        for (channel, change) in changes.iter_mut().enumerate() {
            let reference = self.volts[channel];
            *change = if self.muted[channel] || reference == 0.0 {
                0.0
            } else {
                ((f64::from(volts[channel]) - reference) / reference) as f32
            };
        }
    }
}

#[cfg(test)]
mod tests;
