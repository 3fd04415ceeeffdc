//! Images and voltages to touches: contacts found in one frame, then followed through time.

pub mod correction;
mod detect;
mod image_locator;
mod locate;
mod scan;
mod segment;
mod sensing;
mod sensing_bytes;
mod track;

pub use correction::{Correction, CorrectionData, CorrectionError};
pub use detect::Detector;
pub use locate::{FitQuality, Locator, LocatorModel};
pub use scan::Scan;
pub use segment::{Blob, Segmenter, Threshold};
pub use sensing::{ChannelNoise, Sensing, SensingBuilder};
pub use sensing_bytes::SensingError;
pub use track::Tracker;
