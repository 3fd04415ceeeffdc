//! Converts engines and their inputs to messages of a recording, and back.
//!
//! Invariant: the engine that a recording gives, fed the inputs that it gives, does exactly what the recorded engine did.

mod checks;
mod engine_config;
mod error;
mod input;
mod player;
mod restore;
mod session_writer;

pub use engine_config::{EngineConfig, EngineConfigError};
pub use error::PlayerError;
pub use input::{message_from_input, profile_texts, texts_from_message};
pub use player::{RecordedItem, RecordingPlayer};
pub use restore::ReplayCheck;
pub use session_writer::{RecordedTouches, SessionWriter};
