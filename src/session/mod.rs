//! Recordings of sessions: write, read, recover, export.
//!
//! A recording is an MCAP file (<https://mcap.dev>). First come the attachments that an engine is built from (pad, profile,
//! calibration, matrix, response table), then every input of the engine in order, each followed by its touches and events.
//! During a session each message is written and flushed as it comes; a file that ends cleanly is packed.
//! docs/recordings.md describes the format byte by byte.
//!
//! This part handles bytes and messages; `tape` turns them into engines and inputs. Invariant: whatever the file contains,
//! reading it takes bounded memory and terminates.

mod attachment;
pub mod export;
mod lines;
mod message;
mod parts_block;
mod read;
mod records;
mod recover;
mod schema;
mod setup;
mod summary;
pub mod volts;
mod write;

pub use message::{
    BadMessage, Gap, LostFrames, MatrixName, Message, NamedText, ProfileTexts, RecordedTouch,
    TOPICS, TimeOnly, TouchBlock, Touches, touches_sum,
};
pub use read::{ReadError, Reader};
pub use recover::{CopyError, RecoveryReport, Restore, pack, recover};
pub use setup::{Setup, SetupParts, SlimNames, VERSION, slim_name};
pub use summary::RecordingSummary;
pub use write::{WriteError, Writer};
