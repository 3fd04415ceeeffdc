//! The response table: relative voltage changes for a touch of any place, radius and strength.
//!
//! Touches are located by fitting these responses to a frame (`touch::locate`). The table is solved once per pad
//! ([`ResponseBuilder`]), cached on disk and stored in recordings.

mod build;
mod bytes;
mod derived;
mod interpolate;
mod learned;
mod once_slots;
mod places;
mod quantized;
mod scatter;
mod shape;
mod stretch;
mod symmetry;
mod table;
mod terms;

/// Dimensions that are summed together; a table's rank is a multiple of it.
const LANES: usize = 8;

pub use build::{ResponseBuilder, ResponseRow};
pub use bytes::TableError;
pub use learned::TYPICAL_PRESS_MM2;
pub use scatter::Scatterer;
pub use shape::{SHAPE_UNKNOWNS, Shape, ShapedResponse};
pub use stretch::StretchResponse;
pub use table::{MOST_STRENGTH, Response, ResponseTable, TouchModel, strength_from_rise};
