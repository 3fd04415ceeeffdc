//! Relative voltage changes to an image.
//!
//! Set-up (f64, once per pad) turns the model into one f32 matrix. A frame is one product with it, summed in an order
//! that `kernel` fixes; negative values are cut. L1 is the exception: it iterates, starting from the last frame's answer.
//! The hyperparameter is scaled as in `quadratic`: it does not depend on the pixel size or the unit of the voltages.

mod bytes;
mod imager;
mod kernel;
pub mod l1;
mod linearised;
mod linearised_bytes;
mod quadratic;
mod reconstruction;

pub use imager::Imager;
pub(super) use linearised::dead_channel;
pub use linearised::{LAMBDA, Linearised, PIXEL_MM, SetupError, pixel_grid};
pub use reconstruction::Reconstruction;
