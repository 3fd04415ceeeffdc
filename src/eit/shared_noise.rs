//! Noise that channels share: the gain of the whole board, and of each drive.
//!
//! A current source that wavers moves every reading of a frame, or of a drive, by the same share. Taken as independent noise of each channel it
//! looks like a touch; known as a shared direction it is projected out. The covariance of the relative changes is then
//! C = D + gain 1 1' + drive sum_d b_d b_d', where D holds the channels' own variances and b_d marks the channels of drive d.

/// Share by which the estimates move with each frame: some seconds at 100 frames/s.
const FOLLOW: f64 = 0.01;
/// A shared variance counts once it exceeds the error of its own estimate this many times, ...
const SIGNIFICANT: f64 = 3.0;
/// ... and that of the channels' own noise by this share: less hardly matters, and the own noise is not known better.
const LEAST_SURPLUS: f64 = 1.0;
/// One wild frame moves an estimate at most as a frame this many times as noisy as expected would.
const MOST_TIMES: f64 = 9.0;

/// Variances of the relative gains that channels share.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SharedNoise {
    /// Of the gain common to all channels.
    pub gain: f64,
    /// Of the gain of one drive.
    pub drive: f64,
}

/// Drives of a pad, about: the mean over them carries this share of the variance of each.
const DRIVES: f64 = 16.0;

impl SharedNoise {
    /// Variance that the shared gains add to the mean of all channels.
    #[must_use]
    pub fn of_mean(self) -> f64 {
        self.gain + self.drive / DRIVES
    }
}

/// Learns [`SharedNoise`] from frames whose touches are taken out.
#[derive(Clone, Debug, PartialEq)]
pub struct SharedNoiseEstimator {
    /// Drive of each channel.
    drives: Vec<u16>,
    count: usize,
    /// Running means: of the squared gains, and of what independent noise alone would give.
    squares: SharedNoise,
    expected: SharedNoise,
    /// Sums of one frame: weights and weighted residuals, a drive.
    sums: Vec<[f64; 2]>,
    frames: u64,
    /// The estimate and the common gain after the last frame.
    last: SharedNoise,
    last_gain: f64,
}

/// The gains of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameGain {
    /// The gain common to all channels, relative.
    pub gain: f64,
    /// Its variance from the channels' own noise.
    pub variance: f64,
}

impl SharedNoiseEstimator {
    /// An estimator for channels of the given drives, numbered from 0.
    #[must_use]
    pub fn new(drives: Vec<u16>) -> Self {
        let count = drives.iter().max().map_or(0, |last| usize::from(*last) + 1);
        Self {
            drives,
            count,
            squares: SharedNoise::default(),
            expected: SharedNoise::default(),
            sums: vec![[0.0; 2]; count],
            frames: 0,
            last: SharedNoise::default(),
            last_gain: 0.0,
        }
    }

    /// Takes the residuals of a frame: for each channel the relative change that no touch explains and its own variance;
    /// `None` for a channel that does not count.
    pub fn take_frame(&mut self, residual: impl Fn(usize) -> Option<(f64, f64)>) -> FrameGain {
        self.sums.fill([0.0; 2]);
        for channel in 0..self.drives.len() {
            let Some((value, variance)) = residual(channel) else {
                continue;
            };
            let weight = 1.0 / variance.max(f64::MIN_POSITIVE);
            let sum = &mut self.sums[usize::from(self.drives[channel])];
            sum[0] += weight;
            sum[1] += weight * value;
        }
        let [weights, weighted] = self.sums.iter().fold([0.0; 2], |total, sum| {
            [total[0] + sum[0], total[1] + sum[1]]
        });
        if weights <= 0.0 {
            return FrameGain::default();
        }
        let gain = weighted / weights;
        let (mut square, mut expected, mut drives) = (0.0, 0.0, 0.0);
        for [weight, weighted] in self.sums.iter().filter(|sum| sum[0] > 0.0) {
            let off = weighted / weight - gain;
            square += off * off;
            expected += (1.0 / weight - 1.0 / weights).max(0.0);
            drives += 1.0;
        }
        let rate = FOLLOW.max(1.0 / (self.frames + 1) as f64);
        self.frames += 1;
        let variance = 1.0 / weights;
        follow(
            &mut self.squares.gain,
            &mut self.expected.gain,
            gain * gain,
            variance,
            rate,
        );
        if drives > 1.0 {
            follow(
                &mut self.squares.drive,
                &mut self.expected.drive,
                square / drives,
                expected / drives,
                rate,
            );
        }
        self.last = self.computed();
        self.last_gain = gain;
        FrameGain { gain, variance }
    }

    /// The shared variances that the frames so far show beyond doubt; 0 where they show none.
    #[must_use]
    pub fn estimate(&self) -> SharedNoise {
        self.last
    }

    fn computed(&self) -> SharedNoise {
        // Of n effective frames, the mean square of a Gaussian errs by sqrt(2 / n) of itself.
        let frames = (self.frames as f64).min(2.0 / FOLLOW);
        let error = libm::sqrt(2.0 / frames.max(1.0));
        let beyond = |square: f64, expected: f64, samples: f64| {
            let surplus = square - expected;
            let doubt = (SIGNIFICANT * error / libm::sqrt(samples)).max(LEAST_SURPLUS) * expected;
            if surplus > doubt { surplus } else { 0.0 }
        };
        let drives = (self.count as f64).max(1.0);
        let drive = beyond(self.squares.drive, self.expected.drive, drives);
        // The mean over drives carries a part of what each drive wavers by.
        let gain = beyond(self.squares.gain, self.expected.gain + drive / drives, 1.0);
        SharedNoise { gain, drive }
    }

    /// The gain that the last frame's channels share with a channel, where sharing is seen.
    #[must_use]
    pub fn gain_of(&self, channel: usize) -> f64 {
        let shared = self.last;
        let [weight, weighted] = self.sums[usize::from(self.drives[channel])];
        if shared.drive > 0.0 && weight > 0.0 {
            weighted / weight
        } else if shared.gain > 0.0 {
            self.last_gain
        } else {
            0.0
        }
    }

    /// Drive of each channel.
    #[must_use]
    pub fn drives(&self) -> &[u16] {
        &self.drives
    }
}

fn follow(mean: &mut f64, mean_expected: &mut f64, square: f64, expected: f64, rate: f64) {
    let most = MOST_TIMES * (*mean).max(expected);
    *mean += rate * (square.min(most) - *mean);
    *mean_expected += rate * (expected - *mean_expected);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const DRIVES: usize = 16;
    const EACH: usize = 13;
    const OWN: f64 = 1e-3;

    fn learnt(gain: f64, drive: f64, frames: usize) -> SharedNoise {
        let drives = (0..DRIVES * EACH)
            .map(|channel| (channel / EACH) as u16)
            .collect();
        let mut estimator = SharedNoiseEstimator::new(drives);
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        for _ in 0..frames {
            let common = gain * normal();
            let own: Vec<f64> = (0..DRIVES).map(|_| drive * normal()).collect();
            let values: Vec<f64> = (0..DRIVES * EACH)
                .map(|channel| common + own[channel / EACH] + OWN * normal())
                .collect();
            estimator.take_frame(|channel| Some((values[channel], OWN * OWN)));
        }
        estimator.estimate()
    }

    #[test]
    fn independent_noise_shares_nothing() {
        let shared = learnt(0.0, 0.0, 500);
        assert!(
            shared.gain < 0.02 * OWN * OWN && shared.drive < 0.05 * OWN * OWN,
            "{shared:?}"
        );
    }

    #[test]
    fn shared_gains_are_found_within_a_tenth_or_two() {
        let shared = learnt(3e-3, 0.0, 500);
        assert!((shared.gain.sqrt() / 3e-3 - 1.0).abs() < 0.2, "{shared:?}");
        let shared = learnt(0.0, 3e-3, 500);
        assert!((shared.drive.sqrt() / 3e-3 - 1.0).abs() < 0.1, "{shared:?}");
        assert!(shared.gain.sqrt() < 1e-3, "{shared:?}");
    }
}
