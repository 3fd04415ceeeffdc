//! The reference: what the untouched pad reads, now.
//!
//! Gels dry, warm and creep: each channel drifts on its own way at nearly constant speed, percents a minute. The
//! reference is therefore a level and a rate a channel, kept by a Kalman filter that measures only what no
//! touch changes. Under a touch a channel goes on along its rate and grows less sure of itself, so that a held press never
//! fades and drift under a long hold is foreseen rather than seen as a touch.
//!
//! A touch in one corner leaves the channels of another as they were: these go on being followed, and what they have in
//! common moves the rest. How noisy each channel is, is learnt on the way. (Model: Bar-Shalom, Li and Kirubarajan 2001, section 6.2,
//! the nearly constant velocity model.)

use super::noise::NoiseModel;

/// Frames whose mean is the first reference.
pub const REFERENCE_FRAMES: usize = 10;

/// How fast pads drift before anything is known, as a share a second: 3 % a minute.
const FIRST_RATE_PER_S: f64 = 5e-4;
/// How fast all channels may drift together, a share a second: 12 % a minute.
const FIRST_COMMON_RATE_PER_S: f64 = 2e-3;
/// How much the rate wanders, a share a second within a second.
const RATE_WALK_PER_S: f64 = 5e-5;
/// How much the level wanders beside its rate, a share within a second.
const LEVEL_WALK: f64 = 1e-4;
/// Noise is never taken to be below this share: 100 dB.
const LEAST_NOISE: f64 = 1e-5;
/// Gaps between frames count at most this long: a source that paused must not fling the reference along its rate.
const LONGEST_STEP_S: f64 = 0.2;
/// Frames that pass after a touch before the pad counts as untouched again: the gel springs back.
const SETTLE_FRAMES: u32 = 3;
/// A channel whose first readings spread this many times as widely as the median channel's is dead or loose.
const LOOSE_SPREAD: f64 = 20.0;
/// Share by which the estimate of a channel's noise moves with each frame in which it is free: some seconds.
const NOISE_FOLLOW: f64 = 0.004;
/// Under a touch a channel's own rate is believed for about so long, s: seen for a second, it must not be followed for minutes.
const UNSEEN_RATE_S: f64 = 10.0;
/// A channel is followed if the touches change it by less than this many of its deviations.
const FREE_DEVIATIONS: f64 = 1.0;
/// What the touches are said to change in a channel is wrong by about this share.
const TOUCH_ERROR: f64 = 0.1;

/// The untouched pad's voltages.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    volts: Vec<f64>,
    /// Volts a second.
    rates: Vec<f64>,
    covariances: Vec<Covariance>,
    /// Of the gain that all channels share.
    common: Covariance,
    /// Variance of a reading of each channel, relative.
    noise: Vec<f64>,
    /// Sum over the first frames of the squares of the volts, a channel.
    squares: Vec<f64>,
    /// Channels that are left out.
    muted: Vec<bool>,
    frames: usize,
    quiet_frames: u32,
    last_ns: u64,
    /// What is left of an unseen channel's rate after the last step of time.
    unseen_keep: f64,
}

/// Variance of the level, of the rate, and their covariance, relative to the level.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Covariance {
    level: f64,
    cross: f64,
    rate: f64,
}

impl Covariance {
    /// Of something that has a level, and a rate of the given deviation that is not known yet.
    fn of_rate(rate_per_s: f64) -> Self {
        Self {
            level: 0.0,
            cross: 0.0,
            rate: rate_per_s * rate_per_s,
        }
    }

    /// Less sure after some time.
    fn advance(&mut self, elapsed_s: f64) {
        let Self { level, cross, rate } = *self;
        *self = Self {
            level: level
                + elapsed_s * (2.0 * cross + elapsed_s * rate)
                + LEVEL_WALK * LEVEL_WALK * elapsed_s,
            cross: cross + elapsed_s * rate,
            rate: rate + RATE_WALK_PER_S * RATE_WALK_PER_S * elapsed_s,
        };
    }

    /// A rate of which only a share is still believed.
    fn forget_rate(&mut self, keep: f64) {
        self.cross *= keep;
        self.rate *= keep * keep;
    }

    /// Surer after a measurement of a variance; returns by what level and rate move.
    fn measure(&mut self, surprise: f64, variance: f64) -> (f64, f64) {
        let Self { level, cross, rate } = *self;
        let total = level + variance;
        let (level_gain, rate_gain) = (level / total, cross / total);
        *self = Self {
            level: level - level_gain * level,
            cross: cross - level_gain * cross,
            rate: rate - rate_gain * cross,
        };
        (level_gain * surprise, rate_gain * surprise)
    }
}

impl Reference {
    /// A reference that has seen nothing yet.
    #[must_use]
    pub fn new(channels: usize) -> Self {
        Self {
            volts: vec![0.0; channels],
            rates: vec![0.0; channels],
            covariances: vec![Covariance::of_rate(FIRST_RATE_PER_S); channels],
            common: Covariance::of_rate(FIRST_COMMON_RATE_PER_S),
            noise: vec![LEAST_NOISE * LEAST_NOISE; channels],
            squares: vec![0.0; channels],
            muted: vec![false; channels],
            frames: 0,
            quiet_frames: SETTLE_FRAMES,
            last_ns: 0,
            unseen_keep: 1.0,
        }
    }

    /// Whether the first frames are in, so that changes mean something.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.frames >= REFERENCE_FRAMES
    }

    /// The voltages of the untouched pad, in the instrument's units.
    #[must_use]
    pub fn volts(&self) -> &[f64] {
        &self.volts
    }

    /// Variance of a channel's relative change: of the reading itself, and of the reference's own doubt.
    #[must_use]
    pub fn variances(&self, channel: usize) -> [f64; 2] {
        let doubt = self.covariances[channel].level + self.common.level;
        [self.noise[channel], doubt]
    }

    /// Variance of a relative change in the mean over the channels that count: of the noise and of the reference's own doubt.
    #[must_use]
    pub fn change_variance(&self) -> f64 {
        self.mean(|channel| self.noise[channel] + self.covariances[channel].level)
            + self.common.level
    }

    /// Deviation of a relative change; see [`Self::change_variance`].
    #[must_use]
    pub fn change_noise(&self) -> f64 {
        libm::sqrt(self.change_variance())
    }

    /// By how much the reference's own doubt widens the noise of a change: 1 when it is certain.
    #[must_use]
    pub fn doubt(&self) -> f64 {
        libm::sqrt(self.change_variance() / self.mean(|channel| self.noise[channel]))
    }

    /// Deviations of the readings from frame to frame, relative, one a channel; infinite for one that is left out.
    #[must_use]
    pub fn deviations(&self) -> Vec<f64> {
        self.noise
            .iter()
            .zip(&self.muted)
            .map(|(noise, muted)| {
                if *muted {
                    f64::INFINITY
                } else {
                    libm::sqrt(*noise)
                }
            })
            .collect()
    }

    /// Takes one of the first frames into the mean.
    pub fn begin(&mut self, t_ns: u64, volts: &[f32]) {
        self.frames += 1;
        let share = 1.0 / self.frames as f64;
        for ((level, square), volt) in self.volts.iter_mut().zip(&mut self.squares).zip(volts) {
            let volt = f64::from(*volt);
            *level += share * (volt - *level);
            *square += volt * volt;
        }
        self.last_ns = t_ns;
        if self.is_ready() {
            self.judge_first_frames();
            for (covariance, noise) in self.covariances.iter_mut().zip(&self.noise) {
                covariance.level = noise / self.frames as f64;
            }
        }
    }

    /// Goes on to a time: along the rates, and less sure.
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

    /// Measures a frame at the time to which it has advanced. `volts` are those of the frame less its touches, `touched` what
    /// these change in each channel, relative: the channels that they leave alone are followed one by one; what all have in
    /// common, a gain that they share, moves every one.
    pub fn follow(&mut self, volts: &[f32], touched: &[f32]) {
        self.quiet_frames += 1;
        if self.quiet_frames <= SETTLE_FRAMES {
            return;
        }
        self.follow_common(volts, touched);
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
                self.covariances[channel].forget_rate(self.unseen_keep);
            }
        }
    }

    /// Measures the gain that all channels share, and moves them all by it.
    fn follow_common(&mut self, volts: &[f32], touched: &[f32]) {
        let (mut surprise, mut weights) = (0.0, 0.0);
        for (channel, (volt, touched)) in volts.iter().zip(touched).enumerate() {
            if !self.is_live(channel) {
                continue;
            }
            // The quiet channels tell most, those under a touch hardly anything.
            let error = TOUCH_ERROR * f64::from(*touched);
            let weight =
                1.0 / (self.noise[channel] + self.covariances[channel].level + error * error);
            surprise += weight * (f64::from(*volt) / self.volts[channel] - 1.0);
            weights += weight;
        }
        if weights == 0.0 {
            return;
        }
        let (level_by, rate_by) = self.common.measure(surprise / weights, 1.0 / weights);
        for (volt, rate) in self.volts.iter_mut().zip(&mut self.rates) {
            *volt += level_by * *volt;
            *rate += rate_by * *volt;
        }
    }

    fn is_live(&self, channel: usize) -> bool {
        !self.muted[channel] && self.volts[channel] != 0.0
    }

    /// Measures one channel.
    fn measure(&mut self, channel: usize, volt: f64) {
        let reference = self.volts[channel];
        let surprise = volt / reference - 1.0;
        let level = self.covariances[channel].level;
        let (level_by, rate_by) = self.covariances[channel].measure(surprise, self.noise[channel]);
        self.volts[channel] += level_by * reference;
        self.rates[channel] += rate_by * reference;
        self.follow_noise(channel, surprise * surprise - level);
    }

    /// Lets a frame of a touched pad pass.
    pub fn hold(&mut self) {
        self.quiet_frames = 0;
    }

    /// Takes a channel out, or takes it back with its level corrected by a share.
    pub fn mute(&mut self, channel: usize, muted: bool, corrected_by: f64) {
        self.muted[channel] = muted;
        self.volts[channel] *= 1.0 + corrected_by;
    }

    /// Whether a channel is left out.
    #[must_use]
    pub fn is_muted(&self, channel: usize) -> bool {
        self.muted[channel]
    }

    /// Channels that are left out: they change by nothing.
    #[must_use]
    pub fn muted_channels(&self) -> Vec<usize> {
        (0..self.muted.len())
            .filter(|channel| self.muted[*channel])
            .collect()
    }

    /// The estimate of a channel's noise goes after what a frame shows of it.
    fn follow_noise(&mut self, channel: usize, square: f64) {
        let noise = &mut self.noise[channel];
        // One wild reading is no noise level.
        let square = square.clamp(0.0, 10.0 * *noise);
        *noise = (*noise + NOISE_FOLLOW * (square - *noise)).max(LEAST_NOISE * LEAST_NOISE);
    }

    /// Mean over the channels that count.
    fn mean(&self, of: impl Fn(usize) -> f64) -> f64 {
        let (mut count, mut sum) = (0usize, 0.0);
        for channel in (0..self.muted.len()).filter(|channel| !self.muted[*channel]) {
            count += 1;
            sum += of(channel);
        }
        if count == 0 {
            LEAST_NOISE * LEAST_NOISE
        } else {
            sum / count as f64
        }
    }

    /// Relative changes (v - v0) / v0; a muted channel changes by nothing.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn changes(&self, volts: &[f32], changes: &mut [f32]) {
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

    /// Learns from the spread of the first frames how noisy readings are, and which channels are no readings at all.
    fn judge_first_frames(&mut self) {
        let count = self.frames as f64;
        let variances: Vec<f64> = self
            .volts
            .iter()
            .zip(&self.squares)
            .map(|(mean, square)| (square - count * mean * mean).max(0.0) / (count - 1.0))
            .collect();
        let noise = NoiseModel::of(&self.volts, &variances);
        for (channel, variance) in variances.iter().enumerate() {
            let square = self.volts[channel] * self.volts[channel];
            let expected = noise
                .variance(square)
                .max(LEAST_NOISE * LEAST_NOISE * square);
            self.muted[channel] =
                square == 0.0 || *variance > LOOSE_SPREAD * LOOSE_SPREAD * expected;
            self.noise[channel] = if square == 0.0 {
                1.0
            } else {
                expected / square
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME_NS: u64 = 10_000_000;
    const CHANNELS: usize = 7;

    /// Readings of 1 with a deterministic noise of about 60 dB, and a drift a second.
    fn reading(frame: u64, drift_per_s: f64) -> [f32; CHANNELS] {
        std::array::from_fn(|channel| {
            let wobble = (frame as f64 * 1.7 + channel as f64 * 2.9).sin() * 1.4e-3;
            (1.0 + wobble + drift_per_s * frame as f64 * 0.01) as f32
        })
    }

    fn played(frames: u64, drift_per_s: f64, touched: impl Fn(u64) -> bool) -> Reference {
        let mut reference = Reference::new(CHANNELS);
        for frame in 0..frames {
            let (t_ns, volts) = (frame * FRAME_NS, reading(frame, drift_per_s));
            if !reference.is_ready() {
                reference.begin(t_ns, &volts);
                continue;
            }
            reference.advance(t_ns);
            if touched(frame) {
                reference.hold();
            } else {
                reference.follow(&volts, &[0.0; CHANNELS]);
            }
        }
        reference
    }

    #[test]
    fn it_begins_as_the_mean_of_the_first_frames() {
        let mut reference = Reference::new(1);
        for frame in 0..REFERENCE_FRAMES {
            assert!(!reference.is_ready());
            reference.begin(0, &[frame as f32]);
        }
        assert!(reference.is_ready());
        assert!((reference.volts()[0] - 4.5).abs() < 1e-12);
    }

    #[test]
    fn drift_that_was_seen_is_foreseen_under_a_hold() {
        // 2 % a minute; ten seconds seen, five seconds held.
        let drift = 0.02 / 60.0;
        let reference = played(1500, drift, |frame| frame >= 1000);
        let truth = 1.0 + drift * 15.0;
        for volt in reference.volts() {
            assert!((volt - truth).abs() < 4e-4, "{volt} for {truth}");
        }
        assert!(reference.doubt() > 1.05, "a hold leaves doubt");
    }

    #[test]
    fn a_hold_does_not_move_a_steady_reference() {
        let reference = played(3000, 0.0, |frame| frame >= 1000);
        for volt in reference.volts() {
            assert!((volt - 1.0).abs() < 2e-3, "{volt}");
        }
    }

    #[test]
    fn a_loose_channel_is_left_out() {
        let mut reference = Reference::new(CHANNELS);
        for frame in 0..REFERENCE_FRAMES as u64 {
            let mut volts = reading(frame, 0.0);
            volts[2] = if frame % 2 == 0 { 1.0 } else { -0.4 };
            reference.begin(frame * FRAME_NS, &volts);
        }
        assert_eq!(reference.muted_channels(), [2]);
        let mut changes = [9.0; CHANNELS];
        reference.changes(&[2.0; CHANNELS], &mut changes);
        assert_eq!(changes[2], 0.0);
        assert!(changes[3] > 0.9);
    }

    #[test]
    fn a_dead_channel_changes_by_nothing() {
        let mut reference = Reference::new(1);
        for _ in 0..REFERENCE_FRAMES {
            reference.begin(0, &[0.0]);
        }
        let mut changes = [9.0];
        reference.changes(&[0.5], &mut changes);
        assert_eq!(changes, [0.0]);
    }
}
