//! The readings of an untouched pad, from its frames: robust against the frames and channels that are damaged.

use crate::eit::noise::median;
use crate::eit::quantization::quantization_step;

/// The standard deviation of Gaussian noise over its median absolute deviation.
const DEVIATION_OF_MEDIAN: f64 = 1.4826;

/// The median of each channel over frames, in their unit, and its relative standard deviation; infinite for a channel whose median is
/// zero or not finite. What the board's converter rounds, no number of frames averages out.
#[must_use]
pub fn rest_medians(frames: &[Vec<f32>]) -> (Vec<f64>, Vec<f64>) {
    let channels = frames.first().map_or(0, Vec::len);
    let rounding = quantization_step(frames).unwrap_or(0.0) / 12f64.sqrt();
    let middle = |mut values: Vec<f64>| median(&mut values).unwrap_or(f64::NAN);
    let of_channel = |channel: usize| {
        let values: Vec<f64> = frames
            .iter()
            .map(|volts| f64::from(volts[channel]))
            .collect();
        let median = middle(values.clone());
        let spread = middle(values.iter().map(|value| (value - median).abs()).collect());
        let noise = DEVIATION_OF_MEDIAN * spread / (frames.len() as f64).sqrt();
        let deviation = libm::hypot(noise, rounding) / median.abs();
        match deviation.is_finite() {
            true => (median, deviation),
            false => (median, f64::INFINITY),
        }
    };
    (0..channels).map(of_channel).unzip()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of readings of 0.01 and 1 V with noise of 0.1 %, rounded to a step.
    fn frames(step: f64) -> Vec<Vec<f32>> {
        (0..100)
            .map(|frame| {
                [0.01, 1.0]
                    .iter()
                    .cycle()
                    .take(20)
                    .enumerate()
                    .map(|(channel, volt)| {
                        let noise = (f64::from(frame) * 1.7 + channel as f64 * 2.9).sin();
                        let volt = volt * (1.0 + 1e-3 * noise);
                        ((volt / step).round() * step) as f32
                    })
                    .collect()
            })
            .collect()
    }

    #[test]
    fn a_small_reading_of_a_coarse_converter_is_little_known() {
        let (_, fine) = rest_medians(&frames(1e-9));
        assert!(fine[0] < 2e-4 && fine[1] < 2e-4, "{fine:?}");
        let (_, coarse) = rest_medians(&frames(1e-3));
        assert!((0.02..0.04).contains(&coarse[0]), "{}", coarse[0]);
        assert!(coarse[1] < 5e-4, "{}", coarse[1]);
    }

    #[test]
    fn one_bad_frame_moves_no_median() {
        let mut all = frames(1e-9);
        let (before, _) = rest_medians(&all);
        all[50] = vec![f32::NAN; 20];
        all[51] = vec![-3.0; 20];
        let (after, _) = rest_medians(&all);
        for (after, before) in after.iter().zip(before) {
            assert!((after / before - 1.0).abs() < 2e-4, "{after} for {before}");
        }
    }
}
