//! The noise of a board: two numbers, estimated from the first frames of all channels.

/// Channels with more relative noise than this are ignored: they may be loose.
const USELESS_NOISE: f64 = 0.15;
/// An additive part below this share of the smallest readings' variance is taken for chance.
const LEAST_ADDITIVE: f64 = 0.5;

/// Variance of a reading: a part proportional to the reading squared and an additive part. Ten frames are too few for the
/// noise of one channel, but enough for these two numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NoiseModel {
    proportional: f64,
    additive: f64,
}

impl NoiseModel {
    /// Fits the model to the variances of the channels. Relative variances lie on a line in 1 / V^2, drawn through the
    /// medians of the smallest and the largest third of the readings, so that loose channels have no influence.
    pub(super) fn from_variances(volts: &[f64], variances: &[f64]) -> Self {
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

    /// Variance of a reading, from its square.
    pub(super) fn variance(&self, square: f64) -> f64 {
        self.proportional * square + self.additive
    }
}

/// Medians of the first and the second values of pairs.
fn medians(pairs: &[(f64, f64)]) -> [f64; 2] {
    let parts = [
        pairs.iter().map(|pair| pair.0).collect::<Vec<_>>(),
        pairs.iter().map(|pair| pair.1).collect(),
    ];
    parts.map(|mut values| median(&mut values).unwrap_or(0.0))
}

/// The median (upper one of two), after sorting the values; `None` without values.
pub(crate) fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
