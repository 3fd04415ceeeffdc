//! The reference: what the untouched pad reads, now.
//!
//! Gels dry, warm and creep: each channel drifts on its own way at nearly constant speed, percents a minute. The
//! reference is therefore a level and a rate a channel, kept by a Kalman filter that measures only in frames which
//! the caller declares untouched. While the pad is touched it goes on along its rate and grows less sure of itself, so
//! that a held press never fades and drift under a long hold is foreseen rather than seen as a touch.
//!
//! A touch in one corner leaves the channels of another as they were: these go on being followed, and what they have in
//! common moves the rest. How noisy each channel is, is learnt on the way. (Model: Bar-Shalom, Li and Kirubarajan 2001, section 6.2,
//! the nearly constant velocity model.)

/// Frames whose mean is the first reference.
pub const REFERENCE_FRAMES: usize = 10;

/// How fast pads drift before anything is known, as a share a second: 3 % a minute.
const FIRST_RATE_PER_S: f64 = 5e-4;
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
/// Below this share of the smallest readings' variance, a part that all readings share is taken for chance.
const LEAST_ADDITIVE: f64 = 0.5;
/// Share by which the estimate of a channel's noise moves with each frame in which it is free: some seconds.
const NOISE_FOLLOW: f64 = 0.004;
/// One channel in so many must be free to tell a gain that all share.
const LEAST_FREE: usize = 8;

/// The untouched pad's voltages.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    volts: Vec<f64>,
    /// Volts a second.
    rates: Vec<f64>,
    covariances: Vec<Covariance>,
    /// Variance of a reading of each channel, relative.
    noise: Vec<f64>,
    /// Sum over the first frames of the squares of the volts, a channel.
    squares: Vec<f64>,
    /// Channels that are left out.
    muted: Vec<bool>,
    frames: usize,
    quiet_frames: u32,
    last_ns: u64,
}

/// Variance of the level, of the rate, and their covariance, relative to the level.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Covariance {
    level: f64,
    cross: f64,
    rate: f64,
}

impl Reference {
    /// A reference that has seen nothing yet.
    #[must_use]
    pub fn new(channels: usize) -> Self {
        Self {
            volts: vec![0.0; channels],
            rates: vec![0.0; channels],
            covariances: vec![
                Covariance {
                    level: 0.0,
                    cross: 0.0,
                    rate: FIRST_RATE_PER_S * FIRST_RATE_PER_S,
                };
                channels
            ],
            noise: vec![LEAST_NOISE * LEAST_NOISE; channels],
            squares: vec![0.0; channels],
            muted: vec![false; channels],
            frames: 0,
            quiet_frames: SETTLE_FRAMES,
            last_ns: 0,
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
        [self.noise[channel], self.covariances[channel].level]
    }

    /// Variance of a relative change in the mean over the channels that count: of the noise and of the reference's own doubt.
    #[must_use]
    pub fn change_variance(&self) -> f64 {
        self.mean(|channel| self.noise[channel] + self.covariances[channel].level)
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
        for (level, rate) in self.volts.iter_mut().zip(&self.rates) {
            *level += rate * elapsed_s;
        }
        for covariance in &mut self.covariances {
            let Covariance { level, cross, rate } = *covariance;
            *covariance = Covariance {
                level: level
                    + elapsed_s * (2.0 * cross + elapsed_s * rate)
                    + LEVEL_WALK * LEVEL_WALK * elapsed_s,
                cross: cross + elapsed_s * rate,
                rate: rate + RATE_WALK_PER_S * RATE_WALK_PER_S * elapsed_s,
            };
        }
    }

    /// Measures a frame at the time to which it has advanced, in the channels that are free of any touch. The others move
    /// by what the free ones have in common: a gain that all share.
    pub fn follow(&mut self, volts: &[f32], is_free: impl Fn(usize) -> bool) {
        self.quiet_frames += 1;
        if self.quiet_frames <= SETTLE_FRAMES {
            return;
        }
        let channels = self.volts.len();
        let (mut free, mut common, mut common_rate) = (0usize, 0.0, 0.0);
        for (channel, volt) in volts.iter().enumerate() {
            if self.muted[channel] || self.volts[channel] == 0.0 || !is_free(channel) {
                continue;
            }
            let (level, rate) = self.measure(channel, f64::from(*volt));
            free += 1;
            common += level;
            common_rate += rate;
        }
        if free * LEAST_FREE < channels || free == channels {
            return;
        }
        let (level, rate) = (common / free as f64, common_rate / free as f64);
        for channel in (0..channels).filter(|channel| !is_free(*channel)) {
            let reference = self.volts[channel];
            self.volts[channel] += level * reference;
            self.rates[channel] += rate * reference;
        }
    }

    /// Measures one channel; returns by which shares its level and its rate moved.
    fn measure(&mut self, channel: usize, volt: f64) -> (f64, f64) {
        let Covariance { level, cross, rate } = self.covariances[channel];
        let total = level + self.noise[channel];
        let (level_gain, rate_gain) = (level / total, cross / total);
        let reference = self.volts[channel];
        let surprise = volt - reference;
        self.volts[channel] += level_gain * surprise;
        self.rates[channel] += rate_gain * surprise;
        self.covariances[channel] = Covariance {
            level: level - level_gain * level,
            cross: cross - level_gain * cross,
            rate: rate - rate_gain * cross,
        };
        let relative = surprise / reference;
        self.follow_noise(channel, relative * relative - level);
        (level_gain * relative, rate_gain * relative)
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

/// Variance of a reading as boards make it: a part in proportion to the reading, a part that is the same for all. Ten frames
/// tell one channel's noise too badly, but these two numbers well.
#[derive(Clone, Copy, Debug, PartialEq)]
struct NoiseModel {
    proportional: f64,
    additive: f64,
}

impl NoiseModel {
    /// From the variances of the channels: relative variances are a line in 1 / V^2, laid through the medians of the
    /// smallest and of the largest third of the readings. Loose channels do not sway it.
    fn of(volts: &[f64], variances: &[f64]) -> Self {
        let mut readings: Vec<(f64, f64)> = volts
            .iter()
            .zip(variances)
            .map(|(volt, variance)| (volt * volt, *variance))
            .filter(|(square, _)| *square > 0.0)
            .map(|(square, variance)| (1.0 / square, variance / square))
            .collect();
        readings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let third = readings.len().div_ceil(3);
        let [near, low] = medians(&readings[..third]);
        let [far, high] = medians(&readings[readings.len() - third..]);
        let additive = ((high - low) / (far - near).max(f64::MIN_POSITIVE)).max(0.0);
        if additive * far < LEAST_ADDITIVE * high {
            return Self {
                proportional: medians(&readings)[1],
                additive: 0.0,
            };
        }
        Self {
            proportional: (low - additive * near).max(0.0),
            additive,
        }
    }

    fn variance(&self, square: f64) -> f64 {
        self.proportional * square + self.additive
    }
}

/// Medians of either part of some pairs.
fn medians(pairs: &[(f64, f64)]) -> [f64; 2] {
    let mut parts = [
        pairs.iter().map(|pair| pair.0).collect::<Vec<_>>(),
        pairs.iter().map(|pair| pair.1).collect(),
    ];
    [median(&mut parts[0]), median(&mut parts[1])]
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
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
                reference.follow(&volts, |_| true);
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
