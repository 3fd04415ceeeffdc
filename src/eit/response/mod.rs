//! The response table: relative voltage changes for a touch of any place, radius and strength.
//!
//! Touches are located by fitting these responses to a frame (`touch::locate`). The table is solved once per pad
//! ([`ResponseBuilder`]), cached on disk and stored in recordings.

mod build;
mod bytes;
mod cubic;
mod derived;
mod interpolate;
mod law;
mod learned;
mod once_slots;
mod places;
mod quantized;
mod scatter;
mod shaped;
mod stretch;
mod symmetry;
mod table;
mod terms;
mod touch_model;

/// Dimensions that are summed together; a table's rank is a multiple of it.
const LANES: usize = 8;

pub use build::{ResponseBuilder, ResponseRow};
pub use bytes::TableError;
pub use learned::TYPICAL_PRESS_MM2;
pub use shaped::ShapedResponse;
pub use stretch::StretchResponse;
pub use table::{Response, ResponseTable};
pub use touch_model::{MOST_STRENGTH, SHAPE_UNKNOWNS, Shape, TouchModel, strength_from_rise};
