//! How noisy a board's readings are: two numbers, from the first frames of all channels together.

/// A channel that is noisier than this, relative, says nothing about what the board's noise is like: it may be loose.
const USELESS_NOISE: f64 = 0.15;
/// Below this share of the smallest readings' variance, a part that all readings share is taken for chance.
const LEAST_ADDITIVE: f64 = 0.5;

/// Variance of a reading as boards make it: a part in proportion to the reading, a part that is the same for all. Ten frames
/// tell one channel's noise too badly, but these two numbers well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NoiseModel {
    proportional: f64,
    additive: f64,
}

impl NoiseModel {
    /// From the variances of the channels: relative variances are a line in 1 / V^2, laid through the medians of the
    /// smallest and of the largest third of the readings. Loose channels do not sway it.
    pub(super) fn of(volts: &[f64], variances: &[f64]) -> Self {
        let mut readings: Vec<(f64, f64)> = volts
            .iter()
            .zip(variances)
            .map(|(volt, variance)| (volt * volt, *variance))
            .filter(|(square, _)| *square > 0.0)
            .map(|(square, variance)| (1.0 / square, variance / square))
            .filter(|(_, relative)| *relative < USELESS_NOISE * USELESS_NOISE)
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

    pub(super) fn variance(&self, square: f64) -> f64 {
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
