//! What a detector needs of a pad: the reconstruction matrix and, if the pad has a response table, the model that touches
//! are located with. Both depend on the present weights of the channels.
//!
//! Built at the start and again when an electrode is lost or recovers, outside the engine, which takes it as an input.

use std::sync::Arc;

use super::locate::{LocatedPad, LocatorModel};
use crate::eit::{
    LAMBDA, Linearised, Reconstruction, ResponseTable, SetupError, SharedNoise, median,
};
use crate::pad::{Pad, TouchSign};
use crate::types::Method;

/// Relative standard deviation of every channel until frames show the noise.
const FIRST_DEVIATION: f64 = 1e-3;

/// The noise of a pad's channels, from which their weights follow.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelNoise {
    /// Relative standard deviation of each channel; infinite for one to exclude.
    pub deviations: Vec<f64>,
    /// Noise that channels share.
    pub shared: SharedNoise,
}

impl From<Vec<f64>> for ChannelNoise {
    fn from(deviations: Vec<f64>) -> Self {
        Self {
            deviations,
            shared: SharedNoise::default(),
        }
    }
}

/// A reconstruction and, optionally, a locator model, for given channel weights.
#[derive(Clone, Debug)]
pub struct Sensing {
    /// Reconstructs images.
    pub reconstruction: Arc<Reconstruction>,
    /// Locates touches in the voltages; without it, they are found in images.
    pub locator_model: Option<Arc<LocatorModel>>,
    /// Relative standard deviation of each channel; infinite for an excluded one.
    pub deviations: Vec<f64>,
    /// Noise that channels share, as the weights take it.
    pub shared: SharedNoise,
    /// Factor of each change before the reconstruction, whose matrix is made for it: the median deviation over the
    /// channel's own; 0 for an excluded channel.
    pub image_weights: Vec<f32>,
}

/// Builds the [`Sensing`] of a pad for any weights.
#[derive(Clone, Debug)]
pub struct SensingBuilder {
    linearised: Linearised,
    method: Method,
    touch_sign: TouchSign,
    located_pad: LocatedPad,
    table: Option<Arc<ResponseTable>>,
    /// Drive of each channel.
    drives: Vec<u16>,
}

impl SensingBuilder {
    /// A builder without a response table: touches are found in images.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    pub fn new(pad: &Pad, method: Method) -> Result<Self, SetupError> {
        Ok(Self::from_linearised(
            Linearised::from_pad(pad)?,
            pad,
            method,
        ))
    }

    /// A builder without a response table, from the pad linearised already.
    #[must_use]
    pub fn from_linearised(linearised: Linearised, pad: &Pad, method: Method) -> Self {
        Self {
            linearised,
            method,
            touch_sign: pad.touch_sign,
            located_pad: LocatedPad::from(pad),
            table: None,
            drives: pad.protocol.drives(),
        }
    }

    /// The reconstruction method.
    #[must_use]
    pub fn method(&self) -> Method {
        self.method
    }

    /// The pad's response table, if it has one.
    #[must_use]
    pub fn table(&self) -> Option<&Arc<ResponseTable>> {
        self.table.as_ref()
    }

    /// Adds the pad's response table: touches are located in the voltages.
    ///
    /// # Panics
    /// If the table belongs to a pad with another number of channels.
    #[must_use]
    pub fn with_table(mut self, table: Arc<ResponseTable>) -> Self {
        let channels = self.linearised.jacobian.nrows();
        assert_eq!(table.channels(), channels, "the pad's own table");
        self.table = Some(table);
        self
    }

    /// The sensing before the first frame: all channels weigh the same.
    ///
    /// # Errors
    /// See [`SetupError`].
    pub fn build_initial(&self) -> Result<Sensing, SetupError> {
        self.build(&vec![FIRST_DEVIATION; self.linearised.jacobian.nrows()].into())
    }

    /// The sensing for channels of the given noise; a deviation that is not finite excludes its channel.
    ///
    /// # Errors
    /// See [`SetupError`].
    ///
    /// # Panics
    /// If there is not one deviation per channel.
    pub fn build(&self, noise: &ChannelNoise) -> Result<Sensing, SetupError> {
        let deviations = noise.deviations.as_slice();
        assert_eq!(deviations.len(), self.linearised.jacobian.nrows());
        if !deviations.iter().any(|deviation| deviation.is_finite()) {
            return Err(SetupError::NoChannel);
        }
        let image_weights = image_weights(deviations);
        let mut linearised = self.linearised.clone();
        for pixel in 0..linearised.jacobian.ncols() {
            let column = linearised.jacobian.col_mut(pixel);
            for (entry, weight) in column.iter_mut().zip(&image_weights) {
                *entry *= f64::from(*weight);
            }
        }
        let reconstruction =
            Reconstruction::from_linearised(&linearised, self.method, LAMBDA, self.touch_sign)?;
        let locator_model = self.table.as_ref().map(|table| {
            let table = Arc::clone(table);
            Arc::new(LocatorModel::new(
                table,
                &self.located_pad,
                noise,
                &self.drives,
            ))
        });
        Ok(Sensing {
            reconstruction: Arc::new(reconstruction),
            locator_model,
            deviations: deviations.to_vec(),
            shared: noise.shared,
            image_weights,
        })
    }
}

impl Sensing {
    /// Sensing by images only, all channels weighing the same.
    #[must_use]
    pub fn by_image(reconstruction: Arc<Reconstruction>) -> Self {
        Self {
            deviations: vec![FIRST_DEVIATION; reconstruction.channels()],
            shared: SharedNoise::default(),
            image_weights: vec![1.0; reconstruction.channels()],
            reconstruction,
            locator_model: None,
        }
    }

    /// Number of voltages in a frame.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.deviations.len()
    }

    /// Whether a channel is in use.
    #[must_use]
    pub fn uses_channel(&self, channel: usize) -> bool {
        self.deviations[channel].is_finite()
    }
}

/// The median deviation over the deviation of each channel; 0 for an excluded channel.
fn image_weights(deviations: &[f64]) -> Vec<f32> {
    let mut finite: Vec<f64> = deviations
        .iter()
        .copied()
        .filter(|d| d.is_finite())
        .collect();
    let median = median(&mut finite).unwrap_or(1.0);
    deviations
        .iter()
        .map(|deviation| {
            if deviation.is_finite() {
                (median / deviation) as f32
            } else {
                0.0
            }
        })
        .collect()
}
