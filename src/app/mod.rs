//! What the command line and the window share: they pass a typed request and get a running game or a typed error.
//!
//! Nothing here prints or parses arguments: faces render errors, warnings and progress.

pub(crate) mod calibration;
mod error;
pub(crate) mod error_estimate;
pub mod file_watch;
pub mod focus_gate;
pub(crate) mod folders;
mod gamepads;
pub(crate) mod identify;
pub(crate) mod learned_pad;
mod listeners;
mod load_timeline;
mod local_services;
pub(crate) mod outputs;
pub mod own_files;
pub(crate) mod pads;
pub(crate) mod places;
mod play;
mod play_config;
pub mod port_report;
mod process_match;
pub(crate) mod profiles;
mod read_ahead;
pub(crate) mod recording;
pub(crate) mod recovery;
mod reload;
mod request;
mod restore;
pub mod services;
pub(crate) mod source;
pub mod table_solver;
pub(crate) mod texts;
pub mod timeline;

pub use local_services::LocalServices;

pub(crate) use error::{AppError, first_fault};
pub(crate) use file_watch::{FileWatcher, WatchedFile};
pub(crate) use play::{FirstUse, Game, PreparedGame};
pub(crate) use read_ahead::ReadAhead;
pub(crate) use reload::ReloadNotice;
pub(crate) use table_solver::{TableInProgress, TableSolver};

/// Receives the number of solved rows and of all rows while a pad is solved.
pub(crate) type Progress<'a> = &'a (dyn Fn(usize, usize) + Sync);
