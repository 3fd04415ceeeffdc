//! What Linux and macOS have in common.

pub mod files;
pub mod pseudo_terminal;
pub mod signals;
pub mod terminal;
