//! The practice level: a small platform game, played by the same events that a game would get.
//!
//! ```text
//! Event ─▶ event queue ─▶ controls ─▶ physics + level ─▶ view
//! ```
//! The game runs in steps of 1/60 s. Events carry the source's time, and each is applied in the step in whose time it
//! falls, however rarely the window is drawn: press lengths are as exact as in a game, and the same events give the same
//! run.

mod chart;
mod controls;
mod event_queue;
mod game;
mod jumps;
mod level;
mod physics;
mod scene;
mod tab;
mod view;

pub use game::{Practice, RunStage};
pub use jumps::Jump;
pub use level::SOLUTION;
pub use tab::PracticeTab;
pub use view::{DrawBeside, PracticeView};

#[cfg(test)]
mod tests;
