//! How good the readings are, in the field's figures. Pure: signals and the pad's protocol in, numbers out.

use crate::pad::Protocol;
use crate::runtime::Signals;

/// A channel below this ratio is called bad, dB.
pub const POOR_SNR_DB: f64 = 40.0;
/// Reciprocity worse than this share hints at a wrong order or a loose electrode.
pub const POOR_RECIPROCITY: f64 = 0.05;

/// Figures of the untouched pad's readings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Health {
    /// Signal-to-noise ratio of each channel, dB; none for one that is left out.
    pub snr_db: Vec<Option<f64>>,
    /// Median of these, dB.
    pub median_snr_db: Option<f64>,
    /// Median of |a - b| / mean(|a|, |b|) over reciprocal pairs of channels; none where the protocol has no such pair.
    pub reciprocity: Option<f64>,
    /// The same for each channel that has a partner.
    pub reciprocity_of: Vec<Option<f64>>,
    /// Relative change of the untouched pad since it was first read, a channel each.
    pub drift: Vec<f64>,
    /// Root mean square of what touches do not explain over that of the change, 0 to 1 and more; none while nothing changes.
    pub residual: Option<f64>,
}

/// The figures of signals.
#[must_use]
pub fn health(signals: &Signals, first_reference: &[f32], protocol: &Protocol) -> Health {
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
        median_snr_db: median(snr_db.iter().flatten().copied()),
        snr_db,
        reciprocity: median(reciprocity_of.iter().flatten().copied()),
        reciprocity_of,
        drift,
        residual: residual(signals),
    }
}

/// Driving where one reads and reading where one drives gives the same voltage (Geselowitz 1971).
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

fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

/// Channels that want looking at, worst first: left out, then noisy.
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
    fn a_thousandth_of_noise_is_sixty_decibels_and_a_muted_channel_has_none() {
        let signals = Signals {
            noise: vec![1e-3, 1e-3, f32::INFINITY, 0.1],
            ..Signals::default()
        };
        let health = health(&signals, &[], &still::pad().protocol);
        assert!((health.snr_db[0].expect("a ratio") - 60.0).abs() < 1e-4);
        assert_eq!(health.snr_db[2], None);
        assert_eq!(worst_channels(&health, 9), [2, 3]);
    }

    #[test]
    fn swapped_pairs_read_the_same_and_one_that_does_not_is_found() {
        let pad = still::pad();
        // A voltage that depends on the two pairs alike.
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
        let sound = health(&signals(&reference), &[], &pad.protocol);
        assert_eq!(sound.reciprocity, Some(0.0));
        reference[7] *= 1.5;
        let askew = health(&signals(&reference), &[], &pad.protocol);
        let off = askew.reciprocity_of[7].expect("a partner");
        assert!((off - 0.4).abs() < 1e-6, "{off}");
    }

    #[test]
    fn what_the_touches_explain_leaves_the_rest() {
        let signals = Signals {
            changes: vec![3.0, 4.0],
            explained: vec![3.0, 1.0],
            ..Signals::default()
        };
        let health = health(&signals, &[], &still::pad().protocol);
        assert_eq!(health.residual, Some(0.6));
    }

    #[test]
    fn nothing_measured_gives_no_figures() {
        let health = health(&Signals::default(), &[], &still::pad().protocol);
        assert_eq!(health, Health::default());
    }
}
