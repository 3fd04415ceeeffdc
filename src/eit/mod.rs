//! Voltages to image: mesh, forward model, Jacobian, reconstruction, reference.
//!
//! The forward model (complete electrode model on linear triangles, f64) runs when a pad is set up or
//! simulated. A frame only meets what was made from it: a reference, and one f32 matrix.

pub(crate) mod cholesky;
mod faults;
mod forward;
mod jacobian;
pub mod mesh;
mod noise;
pub mod order;
mod press;
pub mod reconstruct;
mod reference;
pub mod response;

pub use faults::{Faults, Verdict};
pub(crate) use forward::combine;
pub use forward::{ContactModel, Fields, ForwardError, ForwardModel};
pub use jacobian::{element_jacobian, pixel_jacobian};
pub use mesh::{Mesh, MeshSize};
pub use press::{PRESS_UNKNOWNS, Press, pressed};
pub use reconstruct::{Imager, LAMBDA, Linearised, Reconstruction, SetupError};
pub use reference::{REFERENCE_FRAMES, Reference};
pub use response::{ResponseBuilder, ResponseTable};
