//! Why a recording cannot be played.

use super::engine_config::EngineConfigError;
use crate::session::ReadError;

/// Why a recording cannot be played, or not beyond some point.
#[derive(Debug, thiserror::Error)]
pub enum PlayerError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// No engine can be built from its attachments.
    #[error(transparent)]
    EngineConfig(#[from] EngineConfigError),
    /// It contains an input that no engine can have taken.
    #[error("the recording contains an invalid input: {0}")]
    Invalid(String),
}

pub(super) fn invalid(what: String) -> PlayerError {
    PlayerError::Invalid(what)
}
