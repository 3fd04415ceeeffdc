//! Predicts a channel's next value from its past, in integers only, so that encoder and decoder agree on every machine.

/// Fraction bits of the running means.
const FRACTION_BITS: u32 = 4;
/// Weight of a new value in the three predictors, as shifts: the last value, a short mean, a long mean.
const MEAN_SHIFTS: [u32; 3] = [0, 2, 4];
/// Weight of a new error in the mean that chooses among the predictors, as a shift.
const CHOICE_SHIFT: u32 = 2;
/// Weight of a new error in the mean that gives the Rice parameter, as a shift.
const SCALE_SHIFT: u32 = 3;
/// Error that a channel starts with: the noise of f32 readings at 60 dB.
const FIRST_ERROR: i64 = 16_384;

/// The state of one channel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Predictor {
    /// Running means of the values, each with [`FRACTION_BITS`].
    means: [i64; 3],
    /// Mean recent error of each of them.
    errors: [i64; 3],
    /// Mean recent error of the chosen one.
    scale: i64,
    /// Whether the lowest bits of the values were left out: errors are then small, and half a unit counts.
    is_rounded: bool,
    /// Values so far, at most 16: until then all means are plain averages.
    count: i64,
}

impl Predictor {
    /// For values whose lowest `shift` bits were left out.
    pub(super) fn new(value: i32, shift: u32) -> Self {
        let error = (FIRST_ERROR >> shift) << FRACTION_BITS;
        Self {
            means: [i64::from(value) << FRACTION_BITS; 3],
            errors: [error; 3],
            scale: error,
            is_rounded: shift > 0,
            count: 1,
        }
    }

    /// The predicted next value: the mean with the least recent error.
    pub(super) fn predicted(&self) -> i32 {
        let [a, b, c] = self.errors;
        let best = if a < b && a < c {
            0
        } else if b < c {
            1
        } else {
            2
        };
        // The mean of i32 values fits an i32.
        let half = i64::from(self.is_rounded) << (FRACTION_BITS - 1);
        ((self.means[best] + half) >> FRACTION_BITS) as i32
    }

    /// The Rice parameter: a code of mean 2 |error| is shortest near log2(1.6 |error|), for small errors a little above.
    pub(super) fn rice_parameter(&self) -> u32 {
        let factor = if self.is_rounded { 18 } else { 13 };
        let scaled = (self.scale * factor / 8) >> FRACTION_BITS;
        scaled.max(1).ilog2().min(31)
    }

    /// Takes the value that came, and the error of the prediction.
    pub(super) fn update(&mut self, value: i32, error: i32) {
        let value = i64::from(value) << FRACTION_BITS;
        self.count = (self.count + 1).min(1 << MEAN_SHIFTS[2]);
        for ((mean, mean_error), shift) in
            self.means.iter_mut().zip(&mut self.errors).zip(MEAN_SHIFTS)
        {
            let difference = value - *mean;
            *mean_error += (difference.abs() - *mean_error) >> CHOICE_SHIFT;
            *mean += difference / self.count.min(1 << shift);
        }
        let error = i64::from(error).abs() << FRACTION_BITS;
        self.scale += (error - self.scale) >> SCALE_SHIFT;
    }
}
