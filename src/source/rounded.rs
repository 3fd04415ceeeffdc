//! A source whose readings are rounded to a part of their noise: the lower bits of a reading are noise, which cannot be
//! compressed, so recordings shrink to a quarter.
//!
//! Each channel's noise is measured in the first frames, which are not rounded. A step is a power of two between a half and the
//! whole of the standard deviation, so rounding adds at most 4 % to it (the variance of a step is a twelfth of its square).

use super::{Source, SourceError, SourcePace, SourceReading};
use crate::types::{FrameAssembler, Part};

/// Frames from which the noise is measured.
const MEASURED_FRAMES: usize = 20;
/// The largest step as a share of the standard deviation.
const MOST_STEP: f32 = 1.0;
/// The largest step as a share of a reading: a finger that moves in the first frames is not noise.
const MOST_SHARE: f32 = 1.0 / 512.0;
/// Median of the absolute difference of two readings, as a share of their standard deviation.
const MEDIAN_DIFFERENCE: f32 = 0.954;

/// A source with rounded readings.
pub struct RoundedSource {
    source: Box<dyn Source>,
    /// The first frames, until there are enough.
    measured: Vec<Vec<f32>>,
    /// The step of each channel; 0 for one that is not rounded.
    steps: Option<Vec<f32>>,
    assembler: FrameAssembler,
}

impl RoundedSource {
    /// Rounds the readings of a source.
    #[must_use]
    pub fn new(source: Box<dyn Source>) -> Self {
        Self {
            source,
            measured: Vec::new(),
            steps: None,
            assembler: FrameAssembler::default(),
        }
    }

    /// Rounds the voltages from a channel on; whether the noise is known.
    fn round_from(&self, first: usize, volts: &mut [f32]) -> bool {
        let Some(steps) = self.steps.as_ref().and_then(|steps| steps.get(first..)) else {
            return false;
        };
        for (volt, step) in volts.iter_mut().zip(steps) {
            if *step > 0.0 {
                // Plus zero, since a negative zero has other bits.
                *volt = libm::roundf(*volt / step) * step + 0.0;
            }
        }
        true
    }

    /// Rounds a part, or measures the noise with its frame. The very first frames come whole.
    fn round_part(&mut self, part: &mut Part) {
        if self.round_from(part.first, &mut part.volts) {
            return;
        }
        let channels = self.measured.first().map_or(0, Vec::len);
        if let Some(mut frame) = self.assembler.add(part, channels) {
            self.round(&mut frame.volts);
        }
    }

    fn round(&mut self, volts: &mut [f32]) {
        if self.round_from(0, volts) {
            return;
        }
        self.measured.push(volts.to_vec());
        if self.measured.len() == MEASURED_FRAMES {
            self.steps = Some((0..volts.len()).map(|c| self.step(c)).collect());
            self.measured.clear();
        }
    }

    /// The step of a channel by its first readings.
    fn step(&self, channel: usize) -> f32 {
        let readings = self.measured.iter().map(|volts| volts[channel]);
        let mut differences: Vec<f32> = readings
            .clone()
            .zip(readings.clone().skip(1))
            .map(|(one, next)| (next - one).abs())
            .collect();
        differences.sort_unstable_by(f32::total_cmp);
        let deviation = differences[differences.len() / 2] / MEDIAN_DIFFERENCE;
        let least = readings.map(f32::abs).fold(f32::INFINITY, f32::min);
        let most = (MOST_STEP * deviation).min(MOST_SHARE * least);
        match most.is_normal() {
            true => libm::ldexpf(1.0, libm::ilogbf(most)),
            false => 0.0,
        }
    }
}

impl Source for RoundedSource {
    fn pace(&self) -> SourcePace {
        self.source.pace()
    }

    fn read_in_parts(&mut self) {
        self.source.read_in_parts();
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        let mut reading = self.source.read()?;
        match &mut reading {
            SourceReading::Frame(frame) => self.round(&mut frame.volts),
            SourceReading::Part(part) => self.round_part(part),
            // The board may come back with another gain.
            SourceReading::Disconnected { .. } => {
                self.steps = None;
                self.measured.clear();
            }
            _ => {}
        }
        Ok(reading)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Noise;
    use super::*;
    use crate::types::Frame;

    const LEVELS: [f64; 4] = [1.0, -0.37, 0.002, 0.0];

    struct Board(Noise, u64);

    impl Source for Board {
        fn pace(&self) -> SourcePace {
            SourcePace::ByDevice
        }

        fn read(&mut self) -> Result<SourceReading, SourceError> {
            self.1 += 1;
            let (t_ns, volts) = (self.1, self.0.read(&LEVELS));
            Ok(SourceReading::Frame(Frame { t_ns, volts }))
        }
    }

    fn frames(mut source: impl Source) -> Vec<Vec<f32>> {
        let read = |_| match source.read() {
            Ok(SourceReading::Frame(frame)) => frame.volts,
            other => panic!("{other:?}"),
        };
        (0..2000).map(read).collect()
    }

    #[test]
    fn rounding_adds_little_to_the_noise_and_leaves_few_bits() {
        let exact = frames(Board(Noise::new(60.0, 1), 0));
        let rounded = frames(RoundedSource::new(Box::new(Board(Noise::new(60.0, 1), 0))));
        assert_eq!(exact[..MEASURED_FRAMES], rounded[..MEASURED_FRAMES]);
        for (channel, level) in LEVELS.iter().enumerate() {
            let deviation = 1e-3 * level.abs() as f32;
            let mut bits = u32::MAX;
            for (exact, rounded) in exact.iter().zip(&rounded).skip(MEASURED_FRAMES) {
                let [exact, rounded] = [exact, rounded].map(|volts| volts[channel]);
                assert!((exact - rounded).abs() <= 0.8 * deviation);
                bits = bits.min(rounded.to_bits().trailing_zeros());
            }
            assert!(bits >= 12, "channel {channel}: {bits} zero bits");
        }
    }
}
