//! Images of frames.

use std::sync::Arc;

use super::kernel::Padded;
use super::l1::{L1State, Quality};
use super::reconstruction::{Reconstruction, Solver};
use crate::types::Image;

/// Makes images, one frame after the other.
#[derive(Clone, Debug)]
pub struct Imager {
    reconstruction: Arc<Reconstruction>,
    padded: Padded,
    products: Vec<f32>,
    l1: L1State,
    signed: Vec<f64>,
    quality: Option<Quality>,
}

impl Imager {
    /// An imager before its first frame.
    #[must_use]
    pub fn new(reconstruction: Arc<Reconstruction>) -> Self {
        Self {
            reconstruction,
            padded: Padded::default(),
            products: Vec::new(),
            l1: L1State::default(),
            signed: Vec::new(),
            quality: None,
        }
    }

    /// The reconstruction in use.
    #[must_use]
    pub fn reconstruction(&self) -> &Arc<Reconstruction> {
        &self.reconstruction
    }

    /// Whether an image depends on the one before it: L1 starts its search there.
    #[must_use]
    pub(crate) fn has_memory(&self) -> bool {
        matches!(self.reconstruction.solver, Solver::L1(_))
    }

    /// Quality of the last answer of L1; `None` for the other methods.
    #[must_use]
    pub fn quality(&self) -> Option<Quality> {
        self.quality
    }

    /// The image of relative voltage changes: multiplied by the pad's touch sign, then cut at zero. `noise` is the
    /// standard deviation of a change, used by L1 (0 if unknown).
    ///
    /// # Panics
    /// If there is not one change per channel, or the image lies on another grid.
    pub fn image(&mut self, changes: &[f32], noise: f64, image: &mut Image) {
        self.signed_image(changes, noise, image);
        for value in &mut image.values {
            *value = value.max(0.0);
        }
    }

    /// The image before negative values are cut, for measuring ringing.
    ///
    /// # Panics
    /// As [`Self::image`].
    pub fn signed_image(&mut self, changes: &[f32], noise: f64, image: &mut Image) {
        let Reconstruction {
            grid,
            active,
            solver,
            sign,
            ..
        } = &*self.reconstruction;
        assert_eq!(
            image.grid, *grid,
            "the image lies on the grid of the matrix"
        );
        match solver {
            Solver::OneStep(matrix) => {
                assert_eq!(changes.len(), matrix.columns(), "one change per channel");
                self.padded.set(changes);
                matrix.times(&self.padded, &mut self.products);
                for (pixel, product) in active.iter().zip(&self.products) {
                    image.values[*pixel] = sign * product;
                }
            }
            Solver::L1(model) => {
                self.signed.clear();
                self.signed
                    .extend(changes.iter().map(|change| f64::from(sign * change)));
                self.quality = Some(model.solve(&self.signed, noise, &mut self.l1));
                for (column, pixel) in active.iter().enumerate() {
                    let change = self.l1.answer()[column] / model.norm(column);
                    image.values[*pixel] = change as f32;
                }
            }
        }
    }
}
