//! Studies: which pad to build, and what it can show. The paper's figures in two dimensions, and what a designer needs
//! beyond them.

pub mod accuracy;
mod bound;
pub mod figure;
pub mod job;
mod merit;
mod phantom;
pub mod phantoms;
mod report;
pub mod solid;
pub mod thickness;
mod vary;
pub mod width;

pub use crate::eit::{Press, pressed};
pub use bound::{PressBound, Slopes, Touched, place_bound_mm};
pub use merit::{Merit, Raster};
pub use phantom::{Phantom, Shape};
pub use vary::Vary;

use std::path::{Path, PathBuf};

use crate::eit::{ForwardError, SetupError};

/// Why a study cannot be done.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// What was asked for is impossible; nothing was solved.
    #[error("{reason}")]
    Refused {
        /// Why.
        reason: String,
    },
    /// A file cannot be read or written.
    #[error("{}: {error}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// A pad cannot be solved.
    #[error(transparent)]
    Forward(#[from] ForwardError),
    /// A pad gives no image.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A defect of gelpad.
    #[error("a bug in gelpad: {0}")]
    Internal(String),
}

impl StudyError {
    fn file(path: &Path, error: std::io::Error) -> Self {
        Self::File {
            path: path.to_owned(),
            error,
        }
    }
}
