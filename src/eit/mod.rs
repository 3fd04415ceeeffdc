//! Voltages to image: mesh, forward model, Jacobian, reconstruction, reference.
//!
//! The forward model (complete electrode model on linear triangles, f64) runs only when a pad is set up or simulated. A
//! frame is processed with what was computed from it: a reference, an f32 matrix and a response table.

pub(crate) mod cholesky;
mod electrode_monitor;
mod first_frames;
mod forward;
pub mod identify;
mod jacobian;
mod kalman;
pub mod mesh;
mod noise;
pub mod order;
mod press;
mod pressed;
mod quantization;
mod reconnected;
pub mod reconstruct;
mod reference;
pub mod response;
mod saturation;
mod shared_noise;

pub use electrode_monitor::ElectrodeMonitor;
pub use first_frames::FirstFrames;
pub(crate) use forward::combine;
pub use forward::{ContactModel, Fields, ForwardError, ForwardModel};
pub use jacobian::{element_jacobian, pixel_jacobian};
pub use mesh::{Mesh, MeshSize};
pub(crate) use noise::median;
pub use press::{PRESS_UNKNOWNS, Press, conductivity_factor};
pub use pressed::PressedPad;
pub(crate) use quantization::quantization_step;
pub use reconstruct::{Imager, LAMBDA, Linearised, Reconstruction, SetupError};
pub use reference::{REFERENCE_FRAMES, Reference};
pub use response::{ResponseBuilder, ResponseTable, TYPICAL_PRESS_MM2};
pub(crate) use saturation::saturated_channels;
pub use shared_noise::{SharedNoise, SharedNoiseEstimator};
