//! Images and voltages to touches: contacts found in one frame, then followed through time.

mod by_image;
pub mod correction;
mod detect;
mod locate;
mod segment;
mod sensing;
mod sensing_bytes;
mod track;

pub use correction::{Correction, CorrectionData, CorrectionError};
pub use detect::{Detector, FrameTouches};
pub use locate::{Explained, Locating, Locator};
pub use segment::{Blob, Segmenter, Threshold};
pub use sensing::{Sensing, SensingBuilder};
pub use sensing_bytes::SensingError;
pub use track::Tracker;
