//! Why a request cannot be carried out.

use std::io;
use std::path::PathBuf;

use crate::calibrate::recommend::RecommendError;
use crate::calibrate::{CalibrateError, PressesError};
use crate::eit::SetupError;
use crate::files::FileError;
use crate::output::{OutputError, TuioError};
use crate::runtime::RecordError;
use crate::source::SourceError;
use crate::tape::PlayerError;
use crate::types::SourceErrors;

/// Why a request cannot be carried out, and what to do.
#[derive(Debug, thiserror::Error)]
pub(crate) enum AppError {
    /// Mistakes in a pad, profile, user text or script, each with its place.
    #[error(transparent)]
    Text(#[from] SourceErrors),
    /// A file cannot be read.
    #[error("{}: {error}", path.display())]
    Read { path: PathBuf, error: io::Error },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] FileError),
    /// A file has the wrong content.
    #[error("{}: {reason}", path.display())]
    Content { path: PathBuf, reason: String },
    /// No shipped text has this name.
    #[error("no {kind} is named `{name}`\n  help: {help}")]
    UnknownName {
        kind: &'static str,
        name: String,
        help: String,
    },
    /// No user settings have this name.
    #[error("no settings called `{name}`; known: {}\n  help: {help}", known.join(", "))]
    UnknownUser {
        name: String,
        known: Vec<String>,
        help: String,
    },
    /// The source cannot be opened.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The output cannot be opened.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The pad cannot be solved.
    #[error("the pad {pad} gives no image: {error}")]
    NoImage { pad: String, error: SetupError },
    /// A recording cannot be played.
    #[error("{}: {error}", path.display())]
    Recording { path: PathBuf, error: PlayerError },
    /// The receiver of touches cannot be reached.
    #[error(transparent)]
    Tuio(#[from] TuioError),
    /// The recording cannot be started.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The presses cannot be read.
    #[error(transparent)]
    Presses(#[from] PressesError),
    /// The presses give no calibration.
    #[error(transparent)]
    Calibrate(#[from] CalibrateError),
    /// The presses give no recommendation.
    #[error(transparent)]
    Recommend(#[from] RecommendError),
    /// The system cannot create a thread.
    #[error("cannot start a thread: {0}")]
    Thread(io::Error),
    /// The parts of the request do not fit together.
    #[error("{0}")]
    Unsuitable(String),
}

impl AppError {
    /// One line for a window or a status line: of several mistakes in a text, the first with its place.
    pub(crate) fn one_line(&self) -> String {
        match self {
            Self::Text(errors) => first_fault(errors),
            error => error.to_string(),
        }
    }

    /// Whether a recording is cut off or damaged, so that a part of it may be saved.
    pub(crate) fn is_damaged_recording(&self) -> bool {
        let Self::Recording { error, .. } = self else {
            return false;
        };
        match error {
            PlayerError::Read(error) => error.is_damage(),
            PlayerError::EngineConfig(error) => error.is_solved_again(),
            PlayerError::Invalid(_) => true,
        }
    }
}

/// The first mistake in a text as `name:line:column: message`.
pub(crate) fn first_fault(errors: &SourceErrors) -> String {
    let Some(fault) = errors.diagnostics.first() else {
        return errors.name.clone();
    };
    let (line, column) = errors.line_column(fault.span.start);
    format!("{}:{line}:{column}: {}", errors.name, fault.message)
}
