//! What a pad's frames are read with: the matrix of its images and, where it is solved, the table of its touches; both for
//! the weights that its channels have now.
//!
//! Made at the start, and anew when an electrode is lost or comes back: off the engine, which takes it as an input.

use std::sync::Arc;

use super::locate::Locating;
use crate::eit::{LAMBDA, Linearised, Reconstruction, ResponseTable, SetupError};
use crate::pad::{Outline, Pad, TouchSign};
use crate::types::Method;

/// Before any frame is seen, all readings are taken to be equally noisy, relative.
const FIRST_DEVIATION: f64 = 1e-3;

/// A matrix, and what locates touches.
#[derive(Clone, Debug)]
pub struct Sensing {
    /// Makes the images.
    pub reconstruction: Arc<Reconstruction>,
    /// Locates touches; without it, images do.
    pub locating: Option<Arc<Locating>>,
    /// Relative deviation of each channel for which both were made; infinite for one that is left out.
    pub deviations: Vec<f64>,
    /// What each change is multiplied by before an image is made of it: the median deviation over its own, 0 for a channel
    /// that is left out. The matrix is made for changes so weighted.
    pub image_weights: Vec<f32>,
}

/// Makes a pad's [`Sensing`] for any weights.
#[derive(Clone, Debug)]
pub struct SensingBuilder {
    linearised: Linearised,
    method: Method,
    touch_sign: TouchSign,
    outline: Outline,
    table: Option<Arc<ResponseTable>>,
}

impl SensingBuilder {
    /// A builder for a pad. Without a table, touches are found in its images.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    pub fn new(pad: &Pad, method: Method) -> Result<Self, SetupError> {
        Ok(Self {
            linearised: Linearised::of_pad(pad)?,
            method,
            touch_sign: pad.touch_sign,
            outline: pad.outline,
            table: None,
        })
    }

    /// Locates touches by the pad's table.
    ///
    /// # Panics
    /// If the table is of a pad with other channels.
    #[must_use]
    pub fn with_table(mut self, table: Arc<ResponseTable>) -> Self {
        let channels = self.linearised.jacobian.nrows();
        assert_eq!(table.channels(), channels, "the pad's own table");
        self.table = Some(table);
        self
    }

    /// For a pad of which no frame has been seen.
    ///
    /// # Errors
    /// See [`SetupError`].
    pub fn first(&self) -> Result<Sensing, SetupError> {
        self.build(&vec![FIRST_DEVIATION; self.linearised.jacobian.nrows()])
    }

    /// For channels of the given relative deviations; one that is not finite is left out.
    ///
    /// # Errors
    /// See [`SetupError`].
    ///
    /// # Panics
    /// If there is not one deviation a channel.
    pub fn build(&self, deviations: &[f64]) -> Result<Sensing, SetupError> {
        assert_eq!(deviations.len(), self.linearised.jacobian.nrows());
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
        let locating = self
            .table
            .as_ref()
            .map(|table| Arc::new(Locating::new(Arc::clone(table), &self.outline, deviations)));
        Ok(Sensing {
            reconstruction: Arc::new(reconstruction),
            locating,
            deviations: deviations.to_vec(),
            image_weights,
        })
    }
}

impl Sensing {
    /// Images only.
    #[must_use]
    pub fn by_image(reconstruction: Arc<Reconstruction>) -> Self {
        Self {
            deviations: vec![FIRST_DEVIATION; reconstruction.channels()],
            image_weights: vec![1.0; reconstruction.channels()],
            reconstruction,
            locating: None,
        }
    }

    /// Number of voltages in a frame.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.deviations.len()
    }

    /// Whether a channel counts.
    #[must_use]
    pub fn counts(&self, channel: usize) -> bool {
        self.deviations[channel].is_finite()
    }
}

/// One over the deviation of each channel, the median's being one; 0 for a channel that is left out.
fn image_weights(deviations: &[f64]) -> Vec<f32> {
    let mut finite: Vec<f64> = deviations
        .iter()
        .copied()
        .filter(|d| d.is_finite())
        .collect();
    finite.sort_by(f64::total_cmp);
    let median = finite.get(finite.len() / 2).copied().unwrap_or(1.0);
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
