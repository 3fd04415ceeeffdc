//! The step of the converter that a board reads with, found in its readings.
//!
//! An ADC of 12 bits rounds every reading to a multiple of one step. A reading of a few steps then carries an error that no
//! repetition averages out, so its weight has to know the step. The variance of rounding is step^2 / 12 (Widrow and Kollar 2008,
//! *Quantization Noise*, chapter 4).

/// A converter of more steps than this between zero and the largest reading rounds finer than other noise.
const MOST_STEPS: f64 = 262_144.0;
/// Share of the readings that must be multiples of the step.
const LEAST_MULTIPLES: f64 = 0.99;
/// How far from a multiple a reading may be, in steps: the rounding of `f32`.
const TOLERANCE: f64 = 0.05;
/// A step is believed only if some reading differs from another by it; that many distinct gaps are compared.
const LEAST_GAPS: usize = 8;

/// The step of the converter in volts, if the readings of some frames are multiples of one.
///
/// Readings that never change (a noiseless simulation, a repeated frame) show no step.
#[must_use]
pub(crate) fn quantization_step(frames: &[Vec<f32>]) -> Option<f64> {
    let first = frames.first()?;
    let mut gaps: Vec<f64> = Vec::new();
    let mut readings: Vec<f64> = Vec::with_capacity(frames.len());
    for channel in 0..first.len() {
        readings.clear();
        readings.extend(frames.iter().map(|frame| f64::from(frame[channel])));
        readings.sort_by(f64::total_cmp);
        gaps.extend(
            readings
                .windows(2)
                .map(|pair| pair[1] - pair[0])
                .filter(|gap| *gap > 0.0 && gap.is_finite()),
        );
    }
    if gaps.len() < LEAST_GAPS {
        return None;
    }
    gaps.sort_by(f64::total_cmp);
    let largest = frames
        .iter()
        .flatten()
        .map(|volt| f64::from(volt.abs()))
        .fold(0.0, f64::max);
    let least = gaps[0];
    if largest / least > MOST_STEPS {
        return None;
    }
    // The gaps nearest to the least are one step each: their mean is the step to a fraction of `f32`'s rounding.
    let single: Vec<f64> = gaps
        .iter()
        .copied()
        .take_while(|gap| *gap < 1.5 * least)
        .collect();
    let coarse = single.iter().sum::<f64>() / single.len() as f64;
    let step = refined(frames, coarse);
    let (mut multiples, mut count) = (0usize, 0usize);
    for volt in frames.iter().flatten() {
        let steps = f64::from(*volt) / step;
        count += 1;
        multiples += usize::from((steps - libm::rint(steps)).abs() < TOLERANCE);
    }
    (multiples as f64 >= LEAST_MULTIPLES * count as f64).then_some(step)
}

/// A step fitted to larger and larger readings, as far as each can be counted in steps.
fn refined(frames: &[Vec<f32>], coarse: f64) -> f64 {
    let mut sorted: Vec<f64> = frames
        .iter()
        .flatten()
        .map(|volt| f64::from(volt.abs()))
        .filter(|volt| *volt > 0.5 * coarse && volt.is_finite())
        .collect();
    sorted.sort_by(f64::total_cmp);
    let mut step = coarse;
    for volt in sorted {
        let steps = libm::rint(volt / step);
        let off = (volt / step - steps).abs();
        // A small correction per reading keeps one wild value from moving the step.
        if off < 0.25 {
            step += 0.5 * (volt / steps - step);
        }
    }
    step
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Readings from 0.002 to 1 V with a deterministic wobble, rounded to a step.
    fn frames(step: Option<f64>, wobble: f64) -> Vec<Vec<f32>> {
        (0..10)
            .map(|frame| {
                (0..200)
                    .map(|channel| {
                        let volt = 0.002 * 1.032f64.powi(channel);
                        let noise = (f64::from(frame) * 1.7 + f64::from(channel) * 2.9).sin();
                        let volt = volt * (1.0 + wobble * noise);
                        step.map_or(volt, |step| (volt / step).round() * step) as f32
                    })
                    .collect()
            })
            .collect()
    }

    proptest! {
        #[test]
        fn the_step_of_a_converter_is_found(bits in 8u32..15, scale in 0.5..3.0f64) {
            let step = scale / 2f64.powi(bits as i32);
            let found = quantization_step(&frames(Some(step), 3e-3)).expect("a step");
            prop_assert!((found / step - 1.0).abs() < 1e-3, "{found} for {step}");
        }
    }

    #[test]
    fn continuous_and_constant_readings_have_no_step() {
        assert_eq!(quantization_step(&frames(None, 1e-3)), None);
        assert_eq!(quantization_step(&frames(Some(1e-3), 0.0)), None);
        assert_eq!(quantization_step(&[]), None);
    }
}
