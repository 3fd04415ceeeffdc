//! The watcher processes of Windows: their pipes, and their main loop.

pub(in crate::platform) mod held_files;
mod link;
mod process;

pub(in crate::platform) use link::WatcherLink;
pub use process::run_watcher;

/// What a watcher needs to release outputs: nothing but gelpad's process, since the session's keyboard is one.
#[derive(Clone, Copy, Debug)]
pub struct ReleaseHandle;
