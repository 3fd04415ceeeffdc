//! Windows: keys and mouse through `SendInput`; watchers release what a killed gelpad left down.
//!
//! Calls of the system are unsafe for Rust. Each file allows them for itself, keeps them in small functions, and gives the reason
//! why each is sound.

pub mod console;
pub mod desktop;
pub mod files;
mod keyboard;
pub mod memory;
pub mod outputs;
pub mod ports;
pub mod priority;
pub mod processes;
pub mod pseudo_terminal;
mod rights;
mod scan_codes;
mod session_end;
pub mod signals;
pub mod terminal;
pub mod timer;
#[cfg(feature = "vigem")]
mod vigem;
pub(super) mod watch;

pub use watch::run_watcher;
