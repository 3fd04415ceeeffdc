//! Linux: kernel devices, X11 and Wayland as outputs; watchers release what a display holds.

pub mod console;
pub mod desktop;
pub mod memory;
pub mod outputs;
pub mod ports;
pub mod priority;
pub mod processes;
pub mod timer;
pub mod uinput;
pub(super) mod watch;
#[cfg(feature = "wayland")]
pub mod wayland;
pub mod x11;

pub use super::unix::{files, pseudo_terminal, signals, terminal};
pub use watch::run_watcher;
