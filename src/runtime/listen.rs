//! Who is told of every step of the engine: the recorder, and whoever sends touches on.
//!
//! Told on the engine's thread: a listener takes what it needs and returns; it never waits.

use crate::engine::Input;
use crate::types::{Event, Touch};

/// One input of the engine, and what came of it.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// The input.
    pub input: &'a Input,
    /// The touches that are down after it.
    pub touches: &'a [Touch],
    /// The events that came of it.
    pub events: &'a [Event],
}

/// Someone who is told.
pub trait Listener: Send {
    /// Takes a step, without waiting for anything.
    fn step(&mut self, step: &Step<'_>);
}
