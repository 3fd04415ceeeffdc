//! The thickness study.
mod sensor;
pub use sensor::{Placement, conductor};
