//! Noise that channels share: the gain of the whole board, and of each drive.
//!
//! A current source that wavers moves every reading of a frame, or of a drive, by the same share. Taken as independent noise of each channel it
//! looks like a touch; known as a shared direction it is projected out. The covariance of the relative changes is then
//! C = D + gain 1 1' + drive sum_d b_d b_d', where D holds the channels' own variances and b_d marks the channels of drive d.
//!
//! A source that begins to waver is not known yet. But gains that explain all but noise of a frame are no touch, so they are taken out of
//! it from the first frame on.

/// Share by which the estimates move with each frame: some seconds at 100 frames/s.
const FOLLOW: f64 = 0.01;
/// A shared variance counts once it exceeds the error of its own estimate this many times, ...
const SIGNIFICANT: f64 = 3.0;
/// ... and that of the channels' own noise by this share: less hardly matters, and the own noise is not known better.
const LEAST_SURPLUS: f64 = 1.0;
/// One wild frame moves an estimate at most as a frame this many times as noisy as expected would, ...
const MOST_TIMES: f64 = 9.0;
/// ... but not one that gains explain: they explain at least this many squared deviations beyond noise, ...
const LEAST_EXPLAINED: f64 = 60.0;
/// ... and this many times what they leave beyond noise, ...
const EXPLAINED_TIMES: f64 = 4.0;
/// ... and are not larger than this: a board whose gain steps by more is another matter.
const MOST_GAIN: f64 = 0.02;

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
    /// The gain of each drive in the last frame that gains were tried on.
    gains: Vec<f64>,
    frames: u64,
    /// The estimate and the common gain after the last frame.
    last: SharedNoise,
    last_gain: f64,
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
            gains: vec![0.0; count],
            frames: 0,
            last: SharedNoise::default(),
            last_gain: 0.0,
        }
    }

    /// Takes the residuals of a frame: for each channel the relative change that no touch explains and its own variance;
    /// `None` for a channel that does not count.
    pub fn take_frame(&mut self, residual: impl Fn(usize) -> Option<(f64, f64)>) {
        self.sum(residual);
        self.learn(MOST_TIMES);
    }

    /// Whether gains explain all but noise of a frame: one gain of all channels if that is enough, otherwise one of each drive;
    /// [`Self::explaining_gain`] then gives them. `residual` as in [`Self::take_frame`]; with `is_learned` the estimates follow at once.
    pub fn explains_frame(
        &mut self,
        residual: impl Fn(usize) -> Option<(f64, f64)>,
        is_learned: bool,
    ) -> bool {
        let (energy, channels) = self.sum(residual);
        let of_all = mean(&self.total());
        self.gains.fill(of_all);
        if !self.do_gains_explain(energy, channels, 1.0) {
            for (gain, sum) in self.gains.iter_mut().zip(&self.sums) {
                *gain = mean(sum);
            }
            if !self.do_gains_explain(energy, channels, self.count as f64) {
                return false;
            }
        }
        if is_learned {
            self.learn(f64::INFINITY);
        }
        true
    }

    /// The gain of a channel in the last frame that gains explain, relative.
    #[must_use]
    pub fn explaining_gain(&self, channel: usize) -> f64 {
        self.gains[usize::from(self.drives[channel])]
    }

    /// Sums a frame up, and returns its squared deviations and the number of channels that count.
    fn sum(&mut self, residual: impl Fn(usize) -> Option<(f64, f64)>) -> (f64, f64) {
        let (mut energy, mut channels) = (0.0, 0.0);
        self.sums.fill([0.0; 2]);
        for (channel, drive) in self.drives.iter().enumerate() {
            let Some((value, variance)) = residual(channel) else {
                continue;
            };
            let weight = 1.0 / variance.max(f64::MIN_POSITIVE);
            energy += weight * value * value;
            channels += 1.0;
            let sum = &mut self.sums[usize::from(*drive)];
            sum[0] += weight;
            sum[1] += weight * value;
        }
        (energy, channels)
    }

    fn total(&self) -> [f64; 2] {
        let add = |total: [f64; 2], sum: &[f64; 2]| [total[0] + sum[0], total[1] + sum[1]];
        self.sums.iter().fold([0.0; 2], add)
    }

    /// Whether the gains, of which some are unknown, explain all but noise of a frame.
    fn do_gains_explain(&self, energy: f64, channels: f64, unknowns: f64) -> bool {
        let terms = self.gains.iter().zip(&self.sums);
        // A gain g explains 2 g sum(w v) - g^2 sum(w) of the sum of w v^2.
        let explained: f64 = terms
            .map(|(gain, [weight, weighted])| gain * (2.0 * weighted - gain * weight))
            .sum();
        let beyond_noise = explained - unknowns;
        let left = (energy - explained) - (channels - unknowns);
        beyond_noise >= LEAST_EXPLAINED.max(EXPLAINED_TIMES * left)
            && self.gains.iter().all(|gain| gain.abs() <= MOST_GAIN)
    }

    /// Moves the estimates by the sums of a frame, by at most `most_times` what is expected.
    fn learn(&mut self, most_times: f64) {
        let total = self.total();
        if total[0] <= 0.0 {
            return;
        }
        let gain = mean(&total);
        let (mut square, mut expected, mut drives) = (0.0, 0.0, 0.0);
        for sum in self.sums.iter().filter(|sum| sum[0] > 0.0) {
            let off = mean(sum) - gain;
            square += off * off;
            expected += (1.0 / sum[0] - 1.0 / total[0]).max(0.0);
            drives += 1.0;
        }
        let rate = FOLLOW.max(1.0 / (self.frames + 1) as f64);
        self.frames += 1;
        let follow = |mean: &mut f64, mean_expected: &mut f64, square: f64, expected: f64| {
            let most = most_times * (*mean).max(expected);
            *mean += rate * (square.min(most) - *mean);
            *mean_expected += rate * (expected - *mean_expected);
        };
        let (squares, expecteds) = (&mut self.squares, &mut self.expected);
        follow(
            &mut squares.gain,
            &mut expecteds.gain,
            gain * gain,
            1.0 / total[0],
        );
        if drives > 1.0 {
            follow(
                &mut squares.drive,
                &mut expecteds.drive,
                square / drives,
                expected / drives,
            );
        }
        self.last = self.computed();
        self.last_gain = gain;
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
        let sum = &self.sums[usize::from(self.drives[channel])];
        if shared.drive > 0.0 && sum[0] > 0.0 {
            mean(sum)
        } else if shared.gain > 0.0 {
            self.last_gain
        } else {
            0.0
        }
    }
}

/// The mean of a weight and a weighted value; 0 if nothing weighs.
fn mean(sum: &[f64; 2]) -> f64 {
    if sum[0] > 0.0 { sum[1] / sum[0] } else { 0.0 }
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

    /// An estimator that has seen no frame, for drives of [`EACH`] channels.
    fn unlearnt() -> SharedNoiseEstimator {
        SharedNoiseEstimator::new((0..DRIVES * EACH).map(|c| (c / EACH) as u16).collect())
    }

    #[test]
    fn the_gains_of_a_frame_explain_it_and_are_learned_at_once() {
        let by_drive = |channel: usize| 1e-3 * ((channel / EACH) as f64 - 8.0);
        let of_all = |_: usize| -4e-3;
        for gain in [&by_drive as &dyn Fn(usize) -> f64, &of_all] {
            let mut estimator = unlearnt();
            for is_learned in [false, true] {
                let residual = |channel| Some((gain(channel), OWN * OWN));
                assert!(estimator.explains_frame(residual, is_learned));
                let off = |channel| (estimator.explaining_gain(channel) - gain(channel)).abs();
                assert!((0..DRIVES * EACH).all(|channel| off(channel) < 1e-12));
                assert_eq!(estimator.estimate().of_mean() > 0.0, is_learned);
            }
        }
    }

    #[test]
    fn gains_do_not_explain_what_differs_between_channels_or_noise_or_a_large_step() {
        let mut estimator = unlearnt();
        let odd = |channel: usize| if channel % EACH < EACH / 2 { 5e-3 } else { 0.0 };
        let faint = |_: usize| 1e-4;
        let large = |_: usize| 0.03;
        for change in [&odd as &dyn Fn(usize) -> f64, &faint, &large] {
            assert!(!estimator.explains_frame(|channel| Some((change(channel), OWN * OWN)), true));
        }
        assert_eq!(estimator.estimate(), SharedNoise::default());
    }
}
