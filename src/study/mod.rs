//! Design studies: which pad to build, and what a pad can show. Reproduces the paper's two-dimensional figures and adds
//! what a designer needs beyond them.

pub mod accuracy;
mod bound;
pub mod figure;
mod folder;
pub mod job;
mod merit;
mod phantom;
pub mod phantoms;
pub mod protocol;
mod report;
pub mod solid;
pub mod thickness;
mod vary;
pub mod width;

pub use crate::eit::{Press, conductivity_factor};
use bound::mean_distance_mm;
pub use bound::{PressBound, Slopes, place_bound_mm};
pub use merit::{Merit, Raster};
pub use phantom::{Phantom, Shape};
pub use vary::ParameterSweep;

use std::path::{Path, PathBuf};

use crate::eit::{ForwardError, SetupError};
use crate::pad::Pad;

/// Why a study failed.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The settings are impossible; nothing was solved.
    #[error("{reason}")]
    Refused {
        /// Why.
        reason: String,
    },
    /// A file cannot be read or written.
    #[error("{}: {error}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// The forward problem of a pad cannot be solved.
    #[error(transparent)]
    Forward(#[from] ForwardError),
    /// No reconstruction can be built for a pad.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A defect of gelpad.
    #[error("a bug in gelpad: {0}")]
    Internal(String),
}

impl StudyError {
    fn refused(reason: impl Into<String>) -> Self {
        let reason = reason.into();
        Self::Refused { reason }
    }

    fn internal(error: impl std::fmt::Display) -> Self {
        Self::Internal(error.to_string())
    }

    fn file(path: &Path, error: std::io::Error) -> Self {
        Self::File {
            path: path.to_owned(),
            error,
        }
    }
}

/// Parses a pad's TOML text.
///
/// # Errors
/// A text that describes no valid pad.
fn parse_pad(name: &str, toml: &str) -> Result<Pad, StudyError> {
    Pad::from_toml(name, toml).map_err(|error| StudyError::refused(error.to_string()))
}

/// A shell command that repeats a study. The options come from the settings; `--out` names a placeholder.
struct CommandLine(String);

impl CommandLine {
    /// `gelpad PROGRAM --pad PAD`.
    fn new(program: &str, pad: &str) -> Self {
        Self(format!("gelpad {program}")).option("pad", pad)
    }

    /// Adds ` --NAME VALUE`, quoted for a shell where needed.
    fn option(mut self, name: &str, value: impl std::fmt::Display) -> Self {
        let value = value.to_string();
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./=:,+@%".contains(c);
        self.0 += &if !value.is_empty() && value.chars().all(is_plain) {
            format!(" --{name} {value}")
        } else {
            format!(" --{name} '{}'", value.replace('\'', r"'\''"))
        };
        self
    }

    /// Adds ` --NAME` if `given`.
    fn flag(mut self, name: &str, given: bool) -> Self {
        if given {
            self.0 += &format!(" --{name}");
        }
        self
    }

    /// The whole line, with the folder for the results left to fill in.
    fn finish(self) -> String {
        self.0 + " --out DIR"
    }
}
