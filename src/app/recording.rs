//! Recordings: those that are played, and the one that is being made.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use super::AppError;
use super::pads::{no_image, sensing};
use crate::pad::Pad;
use crate::runtime::Recorder;
use crate::session::{Setup, slim_name};
use crate::source::{FileKind, file_kind};
use crate::tape::{EngineConfig, RecordingPlayer};

/// Whether a file is a recording, judged by its first bytes.
pub(crate) fn is_recording(path: &Path) -> Result<bool, AppError> {
    Ok(file_kind(path)? == FileKind::Recording)
}

/// Opens a recording.
pub(crate) fn open_recording(
    path: &Path,
) -> Result<(RecordingPlayer<BufReader<File>>, EngineConfig), AppError> {
    let file = File::open(path).map_err(|error| AppError::Read {
        path: path.to_owned(),
        error,
    })?;
    let mut failed = None;
    let complete = |setup: Setup| match complete_slim(&setup) {
        Ok(completed) => completed.unwrap_or(setup),
        Err(error) => {
            failed = Some(error);
            setup
        }
    };
    let opened = RecordingPlayer::open_with(BufReader::new(file), complete);
    match failed {
        Some(error) => Err(error),
        None => opened.map_err(|error| AppError::Recording {
            path: path.to_owned(),
            error,
        }),
    }
}

/// Solves what a slim recording names; warns if it differs from what was recorded. `None` for a whole recording.
pub(super) fn complete_slim(setup: &Setup) -> Result<Option<Setup>, AppError> {
    let Some(slim) = &setup.slim else {
        return Ok(None);
    };
    let pad = Pad::from_toml("pad", &setup.pad)?;
    let method = slim.method.parse().unwrap_or_default();
    let builder = sensing(&pad, method, &|_, _| ())?;
    let initial = builder
        .build_initial()
        .map_err(|error| no_image(&pad, error))?;
    let locating = initial.locator_model.as_ref();
    let responses = locating.map(|locating| locating.table().to_bytes());
    let sensing = initial.to_bytes();
    let other = [
        ("matrix", slim_name(&sensing) == slim.sensing),
        (
            "response table",
            responses.as_deref().map(slim_name) == slim.responses,
        ),
    ];
    for (name, _) in other.iter().filter(|(_, is_same)| !is_same) {
        tracing::warn!(
            "the {name} that this machine solves differs from the recorded one: events may differ by some milliseconds\n  \
             help: compare with --tolerance-ms"
        );
    }
    Ok(Some(Setup {
        sensing,
        responses,
        ..setup.clone()
    }))
}

/// A recording that is being made.
pub(crate) struct ActiveRecording {
    pub(super) path: PathBuf,
    pub(super) recorder: Recorder,
}

impl ActiveRecording {
    /// Waits until the file is packed; returns a sentence about it, and whether it holds everything.
    pub(crate) fn finish(self) -> (String, bool) {
        let report = self.recorder.join();
        let path = self.path.display();
        let (frames, left_out) = (report.frames, report.omitted_steps);
        match report.error {
            Some(why) => (
                format!(
                    "{path}: {why}: recorded {frames} frames, lost the {left_out} inputs after them"
                ),
                false,
            ),
            None if left_out > 0 => (
                format!(
                    "{path}: recorded {frames} frames, lost {left_out} inputs: the disk was too slow"
                ),
                false,
            ),
            None => {
                let kilobytes = std::fs::metadata(&self.path).map_or(0, |file| file.len() / 1000);
                (
                    format!("{path}: recorded {frames} frames, {kilobytes} kB"),
                    true,
                )
            }
        }
    }
}
