//! Images to touches: contacts found in one frame, then followed through time.

pub mod correction;
mod detect;
mod segment;
mod track;

pub use correction::{Correction, CorrectionData, CorrectionError};
pub use detect::{Detector, FrameTouches};
pub use segment::{Blob, Segmenter, Threshold};
pub use track::Tracker;
