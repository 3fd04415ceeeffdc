//! What makes a recording replay: engines and their inputs to messages, and back.
//!
//! `session` knows bytes and messages, `engine` knows inputs; this part composes them. Invariant: the engine that a recording gives back,
//! fed the inputs that it gives back, does to the bit what the recorded one did.

mod input;
mod kit;
mod player;
mod scribe;

pub use input::{message_of, texts_of};
pub use kit::{Kit, KitError};
pub use player::{Played, Player, PlayerError};
pub use scribe::Scribe;
