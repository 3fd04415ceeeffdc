//! What differs between operating systems: one folder a system, behind one interface.
//!
//! | module | holds |
//! | --- | --- |
//! | `console` | what the program does to its console at the start |
//! | `desktop` | whether a window can open, and be see-through |
//! | `files` | private files, renaming over a file that others read |
//! | `memory` | freed blocks go back to the system |
//! | `outputs` | the outputs of the system, best first |
//! | `ports` | names of serial ports |
//! | `priority` | the priority of threads |
//! | `processes` | running programs, and this one's file |
//! | `pseudo_terminal` | a serial port without hardware |
//! | `signals` | what ends a game: Ctrl-C, a closed terminal, the end of a session |
//! | `terminal` | keys of the live view |
//! | `timer` | fine sleeps |
//!
//! Invariant: only this file and `src/doctor/mod.rs` ask which system it is. Everything else calls the interface.

mod candidate;
mod release_method;
mod terminal_key;

#[cfg(target_os = "linux")]
pub mod linux;
#[cfg(target_os = "linux")]
use linux as system;

#[cfg(target_os = "macos")]
mod macos;
#[cfg(target_os = "macos")]
use macos as system;

#[cfg(windows)]
mod windows;
#[cfg(windows)]
use windows as system;

#[cfg(unix)]
mod unix;

#[cfg(not(target_os = "macos"))]
pub mod watch;

pub use candidate::Candidate;
pub use release_method::ReleaseMethod;
pub use system::{
    console, desktop, files, memory, outputs, ports, priority, processes, pseudo_terminal,
    run_watcher, signals, terminal, timer,
};
