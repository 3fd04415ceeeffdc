//! What the plot can show, one value per channel.

use super::health::{Health, POOR_RECIPROCITY, POOR_SNR_DB};
use crate::runtime::Signals;

/// A quantity with one value per channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quantity {
    /// Voltages of the newest frame and the reference.
    #[default]
    Voltages,
    /// Changes relative to the reference, and the part explained by touches.
    Changes,
    /// Signal-to-noise ratios.
    Noise,
    /// Reciprocity errors.
    Reciprocity,
    /// Change of the reference since the start.
    Drift,
    /// Changes that touches do not explain.
    Residual,
}

impl Quantity {
    pub(super) const ALL: [Self; 6] = [
        Self::Voltages,
        Self::Changes,
        Self::Noise,
        Self::Reciprocity,
        Self::Drift,
        Self::Residual,
    ];

    pub(super) fn name(self) -> &'static str {
        self.texts().0
    }

    pub(super) fn about(self) -> &'static str {
        self.texts().1
    }

    /// Name and explanation.
    fn texts(self) -> (&'static str, &'static str) {
        match self {
            Self::Voltages => (
                "Voltages",
                "Voltage in V/A or the unit of the board. Bars: newest frame. Line: reference, the untouched pad.",
            ),
            Self::Changes => (
                "Changes",
                "Change relative to the reference, %. Bars: measured. Line: explained by the touches.",
            ),
            Self::Noise => (
                "Noise",
                "Signal-to-noise ratio from frame to frame, dB. Below the line is poor.",
            ),
            Self::Reciprocity => (
                "Reciprocity",
                "Reciprocity error, %: difference to the channel with drive and measurement swapped.",
            ),
            Self::Drift => (
                "Drift",
                "Drift, %: change of the reference since the start.",
            ),
            Self::Residual => (
                "Residual",
                "Residual, %: the part of the change that the touches do not explain.",
            ),
        }
    }

    /// Value of a poor channel.
    pub(super) fn limit(self) -> Option<f64> {
        match self {
            Self::Noise => Some(POOR_SNR_DB),
            Self::Reciprocity => Some(POOR_RECIPROCITY * 100.0),
            _ => None,
        }
    }

    /// Measured values and those of the model, which is empty where there is none.
    pub(super) fn values(self, signals: &Signals, figures: &Health) -> (Vec<f64>, Vec<f64>) {
        let scaled = |values: &[f32], factor: f64| -> Vec<f64> {
            values.iter().map(|v| f64::from(*v) * factor).collect()
        };
        let known = |values: &[Option<f64>], factor: f64| -> Vec<f64> {
            values.iter().map(|v| v.unwrap_or(0.0) * factor).collect()
        };
        let Signals {
            changes, explained, ..
        } = signals;
        match self {
            Self::Voltages => (scaled(&signals.volts, 1.0), scaled(&signals.reference, 1.0)),
            Self::Changes => (scaled(changes, 100.0), scaled(explained, 100.0)),
            Self::Noise => (known(&figures.snr_db, 1.0), Vec::new()),
            Self::Reciprocity => (known(&figures.reciprocity_of, 100.0), Vec::new()),
            Self::Drift => (
                figures.drift.iter().map(|drift| drift * 100.0).collect(),
                Vec::new(),
            ),
            Self::Residual => {
                let pairs = changes.iter().zip(explained);
                let rest: Vec<f32> = pairs.map(|(change, fit)| change - fit).collect();
                (scaled(&rest, 100.0), Vec::new())
            }
        }
    }
}
