//! The watcher processes of Linux: their socket, their main loop, and what they need to release outputs.

pub(in crate::platform) mod held_files;
mod link;
mod process;
mod scope;

use std::os::fd::OwnedFd;

pub(in crate::platform) use link::WatcherLink;
pub use process::run_watcher;

/// What a watcher needs to release the outputs of a device.
#[derive(Debug)]
pub enum ReleaseHandle {
    /// An X11 display, and a window of the connection to it.
    X11 {
        /// Name of the display.
        display: String,
        /// The window.
        window: u32,
    },
    /// The connection to shut down.
    Connection(OwnedFd),
}
