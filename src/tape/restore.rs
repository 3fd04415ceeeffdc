//! What a damaged recording needs so that it can be replayed: a complete setup, and inputs that an engine takes.

use super::checks::InputChecks;
use super::engine_config::{EngineConfig, EngineConfigError};
use super::error::PlayerError;
use crate::session::{Message, Setup};

/// Accepts the messages of a damaged recording that replay will take.
pub struct ReplayCheck(InputChecks);

impl ReplayCheck {
    /// For a recording with this setup.
    ///
    /// # Errors
    /// No engine can be built from it.
    pub fn new(setup: &Setup) -> Result<Self, EngineConfigError> {
        let config = EngineConfig::from_setup(setup)?;
        Ok(Self(InputChecks::new(&config.pad, config.table.as_ref())))
    }

    /// Checks a message; `matrix` are the bytes that a matrix message names.
    ///
    /// # Errors
    /// Replay would end there.
    pub fn accept(&mut self, message: &Message, matrix: Option<&[u8]>) -> Result<(), PlayerError> {
        self.0.message(message, matrix)
    }
}
