//! Saves what can be read of a damaged recording: in a file that the player names, or beside it. The damaged file stays as it is.

use std::path::{Path, PathBuf};

use super::restore::Restorer;
use super::{AppError, Progress};
use crate::eit::REFERENCE_FRAMES;
use crate::session::{self, CopyError, RecoveryReport};

/// What was saved of a damaged recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SavedPart {
    /// The new recording.
    pub path: PathBuf,
    /// What it holds, and what was lost or replaced, for the player.
    pub summary: String,
    /// Whether it holds frames, which the window shows; one of a gamepad does not.
    pub has_frames: bool,
}

/// A copy of what can be read of a recording.
pub(crate) struct Recovered {
    /// What was saved, or why nothing was.
    pub(crate) result: Result<RecoveryReport, CopyError>,
    /// What was solved again or replaced, for people: also where nothing is saved, since another pad may be the way on.
    pub(crate) replaced: Vec<String>,
    /// Whether a pad was named but not used.
    pub(crate) is_pad_ignored: bool,
}

/// Copies what can be read of a recording. `pad` names that of a recording whose own cannot be read.
pub(crate) fn recover(
    recording: &Path,
    to: &Path,
    pad: Option<&str>,
    progress: Progress<'_>,
) -> Recovered {
    let mut restorer = Restorer::new(progress, pad);
    let result = session::recover(recording, to, &mut restorer, REFERENCE_FRAMES as u64);
    Recovered {
        result,
        replaced: restorer.replaced,
        is_pad_ignored: restorer.is_pad_ignored,
    }
}

/// Saves the readable part as `NAME-saved.mcap`, or with a number if that exists.
///
/// # Errors
/// Too little can be read to replay it, or the copy cannot be written.
pub(super) fn save_readable_part(
    recording: &Path,
    progress: Progress<'_>,
) -> Result<SavedPart, AppError> {
    let path = unused_name(recording);
    let recovered = recover(recording, &path, None, progress);
    match recovered.result {
        Ok(report) => Ok(SavedPart {
            path,
            summary: summary(&report, &recovered.replaced),
            has_frames: report.frames > 0,
        }),
        Err(error) => Err(AppError::Content {
            path: recording.to_owned(),
            reason: failure(&error.to_string(), &recovered.replaced),
        }),
    }
}

/// Why nothing was saved, what was tried, and the command that tries more. Of all the places that cannot be read, the command tells.
fn failure(error: &str, replaced: &[String]) -> String {
    let reason = error.lines().next().unwrap_or_default();
    let tried: String = replaced.iter().map(|what| format!("\n{what}")).collect();
    format!(
        "{reason}{tried}\nhelp: `gelpad recover FILE -o SAVED` saves elsewhere, and takes another pad with --pad"
    )
}

fn unused_name(recording: &Path) -> PathBuf {
    let stem = recording.file_stem().unwrap_or_default().to_string_lossy();
    let mut name = format!("{stem}-saved.mcap");
    let mut number = 2;
    while recording.with_file_name(&name).exists() {
        name = format!("{stem}-saved-{number}.mcap");
        number += 1;
    }
    recording.with_file_name(name)
}

fn summary(report: &RecoveryReport, replaced: &[String]) -> String {
    let mut text = match report.frames {
        0 => format!("Saved {} states of a gamepad", report.controls),
        frames => format!("Saved {frames} frames"),
    };
    match report.losses {
        0 => {}
        1 => text.push_str("; one place could not be read"),
        losses => text.push_str(&format!("; {losses} places could not be read")),
    }
    for what in replaced {
        text.push_str("; ");
        text.push_str(what);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::recording::open_recording;

    #[test]
    fn an_existing_file_is_never_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = |name: &str| folder.path().join(name);
        let recording = file("level 1.mcap");
        assert_eq!(unused_name(&recording), file("level 1-saved.mcap"));
        for name in ["level 1-saved.mcap", "level 1-saved-2.mcap"] {
            std::fs::write(file(name), "").expect("written");
        }
        assert_eq!(unused_name(&recording), file("level 1-saved-3.mcap"));
    }

    #[test]
    fn what_can_be_read_of_a_cut_recording_is_saved_beside_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let recording = folder.path().join("cut.mcap");
        let whole = include_bytes!("../../tests/data/recordings/version-1.mcap");
        // Without its end; its frames are one chunk before that.
        let cut = &whole[..whole.len() - 100];
        std::fs::write(&recording, cut).expect("written");

        let saved = save_readable_part(&recording, &|_, _| ()).expect("readable");
        assert_eq!(saved.path, folder.path().join("cut-saved.mcap"));
        assert!(
            saved.has_frames && saved.summary.starts_with("Saved "),
            "{saved:?}"
        );
        let (mut player, _) = open_recording(&saved.path).expect("a recording");
        while player.next().expect("whole").is_some() {}
        assert_eq!(std::fs::read(&recording).expect("left"), cut);

        std::fs::write(&recording, &whole[..400]).expect("written");
        let error = save_readable_part(&recording, &|_, _| ()).expect_err("nothing to replay");
        assert!(error.to_string().contains("gelpad recover"), "{error}");
        let files = std::fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(files, 2, "no other file is left");
    }

    #[test]
    fn a_recording_that_is_gone_or_whose_copy_has_no_name_leaves_nothing_behind() {
        let folder = tempfile::tempdir().expect("a folder");
        let gone = folder.path().join("gone.mcap");
        let error = save_readable_part(&gone, &|_, _| ()).expect_err("gone");
        assert!(error.to_string().contains("gone.mcap"), "{error}");

        // The name of the copy is longer than file systems take.
        let long = folder.path().join(format!("{}.mcap", "x".repeat(248)));
        let whole = include_bytes!("../../tests/data/recordings/version-1.mcap");
        std::fs::write(&long, &whole[..whole.len() - 100]).expect("written");
        let error = save_readable_part(&long, &|_, _| ()).expect_err("too long");
        assert!(error.to_string().contains("-o SAVED"), "{error}");
        let files = std::fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(files, 1, "only the damaged one");
    }

    #[test]
    fn the_summary_counts_what_was_lost() {
        let report = |losses| RecoveryReport {
            frames: 1200,
            losses,
            ..RecoveryReport::default()
        };
        assert_eq!(summary(&report(0), &[]), "Saved 1200 frames");
        assert_eq!(
            summary(&report(3), &["the pad is assumed".to_owned()]),
            "Saved 1200 frames; 3 places could not be read; the pad is assumed"
        );
        let gamepad = RecoveryReport {
            controls: 7,
            ..RecoveryReport::default()
        };
        assert_eq!(summary(&gamepad, &[]), "Saved 7 states of a gamepad");
    }
}
