//! Calibration files: presses as CSV, the correction as JSON.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::AppError;
use super::texts::{as_pad_argument, is_path, read_limited};
use crate::calibrate::{Presses, TouchRows};
use crate::files::{self, FileError};
use crate::pad::Pad;
use crate::touch::{Correction, CorrectionData};

/// Limit for presses and calibrations, bytes: 2500 presses of 192 channels take 3 MB.
const MAX_FILE_BYTES: u64 = 256 << 20;
/// First field of a calibration file.
const FORMAT: &str = "gelpad-calibration";
/// The only version.
const VERSION: u32 = 1;

/// A saved calibration.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CalibrationFile {
    format: String,
    version: u32,
    /// Name of the pad.
    pad: String,
    /// Expected error of a lone touch, mm.
    expected_mm: f64,
    correction: CorrectionData,
}

/// Splits what `--pad` and `--calibration` name into a pad and a calibration of it: a pad that was learned from presses (`FILE.toml`) is
/// given as either, and takes the place of the pad.
pub(crate) fn pad_and_calibration(
    pad: Option<String>,
    calibration: Option<PathBuf>,
) -> (Option<String>, Option<PathBuf>) {
    match calibration {
        Some(file) if is_pad_file(&file) => (Some(as_pad_argument(&file)), None),
        calibration => (pad, calibration),
    }
}

/// Whether a file is a pad's text, by its name.
pub(crate) fn is_pad_file(file: &Path) -> bool {
    file.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// Reads presses.
pub(crate) fn load_presses(path: &Path) -> Result<Presses, AppError> {
    let text = read_limited(path, MAX_FILE_BYTES)?;
    Ok(Presses::from_csv(&path.display().to_string(), &text)?)
}

/// Reads rows of one or several touches; a file of single presses counts as such, too.
pub(crate) fn load_touch_rows(path: &Path) -> Result<TouchRows, AppError> {
    let text = read_limited(path, MAX_FILE_BYTES)?;
    let name = path.display().to_string();
    if TouchRows::has_header(&text) {
        return Ok(TouchRows::from_csv(&name, &text)?);
    }
    let presses = Presses::from_csv(&name, &text)?;
    Ok(TouchRows::from_presses(&presses))
}

/// Reads a calibration of a pad.
pub(crate) fn load(path: &Path, pad: &Pad) -> Result<Correction, AppError> {
    let content_error = |reason: String| AppError::Content {
        path: path.to_owned(),
        reason,
    };
    let text = read_limited(path, MAX_FILE_BYTES)?;
    let file: CalibrationFile = serde_json::from_str(&text).map_err(|error| {
        content_error(format!(
            "this is not a calibration ({error})\n  help: `gelpad calibrate` makes one"
        ))
    })?;
    if file.format != FORMAT || file.version != VERSION {
        return Err(content_error(format!(
            "unknown format {} version {}\n  help: calibrate again with this gelpad",
            file.format, file.version
        )));
    }
    let correction =
        Correction::new(file.correction).map_err(|error| content_error(error.to_string()))?;
    let (has, needs) = (correction.channels(), pad.channels());
    let mismatch = if has != needs {
        format!(
            "made for the pad {} with {has} channels, but {} has {needs}",
            file.pad, pad.name
        )
    } else if file.pad != pad.name {
        format!("made for the pad {}, not {}", file.pad, pad.name)
    } else {
        return Ok(correction);
    };
    Err(content_error(format!(
        "{mismatch}\n  help: choose its pad with --pad, or calibrate this one"
    )))
}

/// Saves a calibration; `expected_mm` is the expected error of a single touch.
pub(crate) fn save(
    path: &Path,
    pad: &Pad,
    correction: &Correction,
    expected_mm: f64,
) -> Result<(), AppError> {
    let file = CalibrationFile {
        format: FORMAT.to_owned(),
        version: VERSION,
        pad: pad.name.clone(),
        expected_mm,
        correction: correction.data().clone(),
    };
    let json = serde_json::to_vec(&file).map_err(|error| FileError::new(path, error.into()))?;
    Ok(files::write(path, &json)?)
}

/// The default file of a pad's calibration: beside the pad's file, or in the current folder for a shipped pad.
pub(crate) fn default_path(argument: &str, pad: &Pad) -> PathBuf {
    let file = format!("{}.calibration.json", pad.name);
    if is_path(argument) {
        Path::new(argument).with_file_name(file)
    } else {
        PathBuf::from(file)
    }
}
