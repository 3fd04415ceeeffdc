//! What stands before the messages of a recording.

use crc::{CRC_64_XZ, Crc};
use serde::{Deserialize, Serialize};

use super::message::ProfileTexts;

/// The format version that this program writes, and the newest that it reads.
pub const VERSION: u32 = 4;

/// The name of the format, in the header and in the first metadata record.
pub(super) const FORMAT: &str = "gelpad";
/// Names of the attachments.
pub(super) const PAD: &str = "pad.toml";
pub(super) const PROFILE: &str = "profile.json";
pub(super) const CALIBRATION: &str = "calibration.json";
pub(super) const SENSING: &str = "sensing.bin";
pub(super) const RESPONSES: &str = "responses.bin";
pub(super) const SLIM: &str = "slim.json";

/// Matrix and response table of a slim recording: named by the CRC-64 (XZ) of their bytes, and solved again to replay it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SlimNames {
    /// The reconstruction method of the matrix.
    pub method: String,
    /// Of `sensing.bin`.
    pub sensing: u64,
    /// Of `responses.bin`, if touches are located with a table.
    pub responses: Option<u64>,
}

/// The CRC-64 by which a slim recording names a matrix or a table.
#[must_use]
pub fn slim_name(bytes: &[u8]) -> u64 {
    const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);
    CRC.checksum(bytes)
}

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
    /// In a slim recording, instead of matrix and table, which are empty.
    pub slim: Option<SlimNames>,
}

impl Setup {
    /// The setup of a slim recording.
    #[must_use]
    pub fn into_slim(self, method: &str) -> Self {
        let slim = SlimNames {
            method: method.to_owned(),
            sensing: slim_name(&self.sensing),
            responses: self.responses.as_deref().map(slim_name),
        };
        Self {
            sensing: Vec::new(),
            responses: None,
            slim: Some(slim),
            ..self
        }
    }
}

/// Those attachments that can be read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SetupParts {
    /// As in [`Setup`].
    pub pad: Option<String>,
    /// As in [`Setup`].
    pub profile: Option<ProfileTexts>,
    /// As in [`Setup`].
    pub calibration: Option<Vec<u8>>,
    /// As in [`Setup`].
    pub sensing: Option<Vec<u8>>,
    /// As in [`Setup`].
    pub responses: Option<Vec<u8>>,
    /// As in [`Setup`].
    pub slim: Option<SlimNames>,
}

impl SetupParts {
    /// The setup; else the name of what is missing.
    pub(super) fn complete(self) -> Result<Setup, &'static str> {
        Ok(Setup {
            pad: self.pad.ok_or("pad")?,
            profile: self.profile.ok_or("profile")?,
            calibration: self.calibration,
            sensing: match &self.slim {
                Some(_) => self.sensing.unwrap_or_default(),
                None => self.sensing.ok_or("matrix")?,
            },
            responses: self.responses,
            slim: self.slim,
        })
    }
}
