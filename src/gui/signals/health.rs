//! Signal quality: noise, reciprocity error, drift and residual. No drawing.

use crate::pad::Protocol;
use crate::runtime::Signals;
use crate::stats::quantile;

/// A channel with a lower signal-to-noise ratio is poor, dB.
pub const POOR_SNR_DB: f64 = 40.0;
/// A larger reciprocity error suggests a wrong order of channels or a loose electrode.
pub const POOR_RECIPROCITY: f64 = 0.05;

/// Signal quality of a pad.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Health {
    /// Signal-to-noise ratio of each channel, dB; none for an excluded channel.
    pub snr_db: Vec<Option<f64>>,
    /// Median of `snr_db`, dB.
    pub median_snr_db: Option<f64>,
    /// Median of `reciprocity_of`; none if the protocol has no reciprocal pairs.
    pub reciprocity: Option<f64>,
    /// |a - b| / mean(|a|, |b|) of each channel and its reciprocal one.
    pub reciprocity_of: Vec<Option<f64>>,
    /// Relative change of the reference of each channel since the start.
    pub drift: Vec<f64>,
    /// Root mean square of the unexplained change over that of the whole change; none without any change.
    pub residual: Option<f64>,
}

/// Computes the signal quality; `first_reference` is the reference at the start.
pub fn from_signals(signals: &Signals, first_reference: &[f32], protocol: &Protocol) -> Health {
    let snr_db: Vec<Option<f64>> = signals
        .noise
        .iter()
        .map(|noise| {
            let noise = f64::from(*noise);
            (noise.is_finite() && noise > 0.0).then(|| -20.0 * noise.log10())
        })
        .collect();
    let reciprocity_of = reciprocity_of(&signals.reference, protocol);
    let drift = signals
        .reference
        .iter()
        .zip(first_reference)
        .map(|(now, first)| {
            if *first == 0.0 {
                0.0
            } else {
                f64::from((now - first) / first)
            }
        })
        .collect();
    Health {
        median_snr_db: quantile(snr_db.iter().flatten().copied(), 0.5),
        snr_db,
        reciprocity: quantile(reciprocity_of.iter().flatten().copied(), 0.5),
        reciprocity_of,
        drift,
        residual: residual(signals),
    }
}

/// Swapping drive and measurement gives the same voltage (Geselowitz 1971).
fn reciprocity_of(reference: &[f32], protocol: &Protocol) -> Vec<Option<f64>> {
    if reference.len() != protocol.channels.len() {
        return Vec::new();
    }
    protocol
        .channels
        .iter()
        .enumerate()
        .map(|(index, channel)| {
            let partner = protocol.channels.iter().position(|other| {
                other.drive == channel.measure && other.measure == channel.drive
            })?;
            let (a, b) = (f64::from(reference[index]), f64::from(reference[partner]));
            let size = (a.abs() + b.abs()) / 2.0;
            (size > 0.0).then(|| (a - b).abs() / size)
        })
        .collect()
}

fn residual(signals: &Signals) -> Option<f64> {
    let square = |values: &mut dyn Iterator<Item = f32>| {
        values.map(|v| f64::from(v) * f64::from(v)).sum::<f64>()
    };
    let whole = square(&mut signals.changes.iter().copied());
    let rest = square(
        &mut signals
            .changes
            .iter()
            .zip(&signals.explained)
            .map(|(change, explained)| change - explained),
    );
    (whole > 0.0).then(|| (rest / whole).sqrt())
}

/// At most `most` poor channels, worst first: excluded ones, then noisy ones.
#[must_use]
pub fn worst_channels(health: &Health, most: usize) -> Vec<usize> {
    let mut bad: Vec<(f64, usize)> = health
        .snr_db
        .iter()
        .enumerate()
        .map(|(channel, snr)| (snr.unwrap_or(f64::NEG_INFINITY), channel))
        .filter(|(snr, _)| *snr < POOR_SNR_DB)
        .collect();
    bad.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    bad.into_iter().take(most).map(|(_, c)| c).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::still;

    #[test]
    fn noise_of_a_thousandth_is_60_db_and_an_excluded_channel_has_no_ratio() {
        let signals = Signals {
            noise: vec![1e-3, 1e-3, f32::INFINITY, 0.1],
            ..Signals::default()
        };
        let health = from_signals(&signals, &[], &still::pad().protocol);
        assert!((health.snr_db[0].expect("a ratio") - 60.0).abs() < 1e-4);
        assert_eq!(health.snr_db[2], None);
        assert_eq!(worst_channels(&health, 9), [2, 3]);
    }

    #[test]
    fn a_channel_that_violates_reciprocity_is_found() {
        let pad = still::pad();
        // Symmetric in drive and measurement.
        let mut reference: Vec<f32> = pad
            .protocol
            .channels
            .iter()
            .map(|c| 1.0 + (c.drive.0 + c.measure.0) as f32)
            .collect();
        let signals = |reference: &[f32]| Signals {
            reference: reference.to_vec(),
            ..Signals::default()
        };
        let exact = from_signals(&signals(&reference), &[], &pad.protocol);
        assert_eq!(exact.reciprocity, Some(0.0));
        reference[7] *= 1.5;
        let wrong = from_signals(&signals(&reference), &[], &pad.protocol);
        let error = wrong.reciprocity_of[7].expect("a partner");
        assert!((error - 0.4).abs() < 1e-6, "{error}");
    }

    #[test]
    fn the_residual_is_the_unexplained_share() {
        let signals = Signals {
            changes: vec![3.0, 4.0],
            explained: vec![3.0, 1.0],
            ..Signals::default()
        };
        let health = from_signals(&signals, &[], &still::pad().protocol);
        assert_eq!(health.residual, Some(0.6));
    }

    #[test]
    fn without_measurements_there_are_no_figures() {
        let health = from_signals(&Signals::default(), &[], &still::pad().protocol);
        assert_eq!(health, Health::default());
    }
}
