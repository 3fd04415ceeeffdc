//! Images to touches: contacts found in one frame, then followed through time.

mod detect;
mod segment;
mod track;

pub use detect::{Detector, FrameTouches};
pub use segment::{Blob, Segmenter, Threshold};
pub use track::Tracker;
