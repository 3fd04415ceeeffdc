//! Recordings of sessions: written, read, recovered, exported.
//!
//! A recording is an MCAP file (<https://mcap.dev>). First come the attachments that an engine is made of (pad, profile,
//! calibration, matrix, table of responses), then every input of the engine in the order in which it was taken, and what came of
//! each. While a session runs each message is written and flushed as it comes; a file that ends cleanly is packed.
//! docs/recordings.md has the format to the byte.
//!
//! This part is about bytes and messages; `tape` makes engines and inputs of them. Invariant: whatever the file
//! holds, reading it takes bounded memory and ends.

pub mod export;
mod lines;
mod message;
mod read;
mod records;
mod recover;
mod schema;
pub mod volts;
mod write;

pub use message::{
    At, BadMessage, Gap, Lost, MatrixName, Message, NamedText, ProfileTexts, TOPICS, TouchSeen,
    Touches, touches_sum,
};
pub use read::{ReadError, Reader};
pub use recover::{CopyError, Salvage, pack, recover};
pub use write::{WriteError, Writer};

/// The format that this program writes, and the newest that it reads.
pub const VERSION: u32 = 1;

/// What the file calls itself in its header and its first metadata record.
const FORMAT: &str = "gelpad";
/// Names of the attachments that an engine is made of.
const PAD: &str = "pad.toml";
const PROFILE: &str = "profile.json";
const CALIBRATION: &str = "calibration.json";
const SENSING: &str = "sensing.bin";
const RESPONSES: &str = "responses.bin";

/// What an engine is made of, as bytes and texts.
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
    /// The table of responses.
    pub responses: Option<Vec<u8>>,
}
