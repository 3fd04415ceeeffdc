//! What stands before the messages of a recording.

use super::message::ProfileTexts;

/// The format version that this program writes, and the newest that it reads.
pub const VERSION: u32 = 1;

/// The name of the format, in the header and in the first metadata record.
pub(super) const FORMAT: &str = "gelpad";
/// Names of the attachments.
pub(super) const PAD: &str = "pad.toml";
pub(super) const PROFILE: &str = "profile.json";
pub(super) const CALIBRATION: &str = "calibration.json";
pub(super) const SENSING: &str = "sensing.bin";
pub(super) const RESPONSES: &str = "responses.bin";

/// The attachments that an engine is built from, as bytes and texts.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// The pad's text.
    pub pad: String,
    /// The profile at the start.
    pub profile: ProfileTexts,
    /// The correction of places, as JSON.
    pub calibration: Option<Vec<u8>>,
    /// Matrix and weights at the start.
    pub sensing: Vec<u8>,
    /// The response table.
    pub responses: Option<Vec<u8>>,
}
