//! Recordings: those that are played, and the one that is being made.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use super::AppError;
use crate::runtime::Recorder;
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
    RecordingPlayer::open(BufReader::new(file)).map_err(|error| AppError::Recording {
        path: path.to_owned(),
        error,
    })
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
