//! The reference: what the untouched pad reads.
//!
//! It begins as the mean of the first frames and then follows slow drift, but only in frames that the caller
//! declares untouched, so that a held press never fades into it.

/// Frames whose mean is the first reference.
pub const REFERENCE_FRAMES: usize = 10;

/// How fast the reference follows an untouched pad, as the time after which 63 % of a step is taken over.
/// Long against a touch's onset (tens of ms), short against drift (percents a minute).
const FOLLOW_S: f64 = 1.0;

/// Gaps between frames count at most this long: a source that paused must not jump the reference.
const LONGEST_STEP_S: f64 = 0.1;

/// The untouched pad's voltages.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    volts: Vec<f64>,
    frames: usize,
    last_ns: u64,
}

impl Reference {
    /// A reference that has seen nothing yet.
    #[must_use]
    pub fn new(channels: usize) -> Self {
        Self {
            volts: vec![0.0; channels],
            frames: 0,
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

    /// Takes one of the first frames into the mean.
    pub fn begin(&mut self, t_ns: u64, volts: &[f32]) {
        self.frames += 1;
        let share = 1.0 / self.frames as f64;
        self.step(volts, share);
        self.last_ns = t_ns;
    }

    /// Moves towards a frame of the untouched pad.
    pub fn follow(&mut self, t_ns: u64, volts: &[f32]) {
        let elapsed_s = t_ns.saturating_sub(self.last_ns) as f64 * 1e-9;
        self.step(volts, elapsed_s.min(LONGEST_STEP_S) / FOLLOW_S);
        self.last_ns = t_ns;
    }

    /// Lets a frame of a touched pad pass.
    pub fn hold(&mut self, t_ns: u64) {
        self.last_ns = t_ns;
    }

    /// Relative changes (v - v0) / v0; a channel that reads nothing changes by nothing.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn changes(&self, volts: &[f32], changes: &mut [f32]) {
        assert_eq!(volts.len(), self.volts.len());
        assert_eq!(changes.len(), self.volts.len());
        for ((change, volt), reference) in changes.iter_mut().zip(volts).zip(&self.volts) {
            *change = if *reference == 0.0 {
                0.0
            } else {
                ((f64::from(*volt) - reference) / reference) as f32
            };
        }
    }

    fn step(&mut self, volts: &[f32], share: f64) {
        for (reference, volt) in self.volts.iter_mut().zip(volts) {
            *reference += share * (f64::from(*volt) - *reference);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME_NS: u64 = 10_000_000;

    fn ready(volt: f32) -> Reference {
        let mut reference = Reference::new(1);
        for frame in 0..REFERENCE_FRAMES as u64 {
            assert!(!reference.is_ready());
            reference.begin(frame * FRAME_NS, &[volt]);
        }
        assert!(reference.is_ready());
        reference
    }

    #[test]
    fn it_begins_as_the_mean_of_the_first_frames() {
        let mut reference = Reference::new(1);
        for frame in 0..REFERENCE_FRAMES {
            reference.begin(0, &[frame as f32]);
        }
        assert!((reference.volts()[0] - 4.5).abs() < 1e-12);
    }

    #[test]
    fn it_follows_drift_and_not_a_touch() {
        let mut reference = ready(1.0);
        let mut t = 10 * FRAME_NS;
        for _ in 0..1000 {
            reference.hold(t);
            t += FRAME_NS;
        }
        assert_eq!(reference.volts(), [1.0]);
        for _ in 0..1000 {
            reference.follow(t, &[1.1]);
            t += FRAME_NS;
        }
        assert!((reference.volts()[0] - 1.1).abs() < 1e-4);
    }

    #[test]
    fn a_dead_channel_changes_by_nothing() {
        let reference = ready(0.0);
        let mut changes = [9.0];
        reference.changes(&[0.5], &mut changes);
        assert_eq!(changes, [0.0]);
    }
}
