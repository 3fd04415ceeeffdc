//! Listeners to every step of the engine: the recorder, and the sender of touches.

use crate::engine::Input;
use crate::types::{Event, Touch};

/// One input of the engine and its results.
#[derive(Clone, Copy, Debug)]
pub struct EngineStep<'a> {
    /// The input.
    pub input: &'a Input,
    /// The touches that are down after it.
    pub touches: &'a [Touch],
    /// The events that it caused.
    pub events: &'a [Event],
}

/// Receives every step, on the engine's thread.
pub trait StepListener: Send {
    /// Takes what it needs from a step. It must not wait.
    fn on_step(&mut self, step: &EngineStep<'_>);
}
