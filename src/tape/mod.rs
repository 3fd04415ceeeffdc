//! Converts engines and their inputs to messages of a recording, and back.
//!
//! Invariant: the engine that a recording gives, fed the inputs that it gives, does exactly what the recorded engine did.

mod engine_config;
mod input;
mod player;
mod session_writer;

pub use engine_config::{EngineConfig, EngineConfigError};
pub use input::{message_from_input, profile_texts};
pub use player::{PlayerError, RecordedItem, RecordingPlayer};
pub use session_writer::SessionWriter;
