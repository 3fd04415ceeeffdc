//! Files of a calibration: presses as CSV, the saved correction as JSON.

use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use serde::{Deserialize, Serialize};

use crate::calibrate::Presses;
use crate::pad::Pad;
use crate::touch::{Correction, CorrectionData};

/// No file of presses or calibration is larger, bytes: 2500 presses of 192 channels take 3 MB.
const LARGEST_FILE: u64 = 256 << 20;
/// What a calibration file calls itself.
const FORMAT: &str = "gelpad-calibration";
/// The version that this program writes, and the only one there is.
const VERSION: u32 = 1;

/// A calibration as it is saved.
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

/// Reads presses.
pub(super) fn presses(path: &Path) -> anyhow::Result<Presses> {
    let text = read(path)?;
    Ok(Presses::from_csv(&path.display().to_string(), &text)?)
}

/// Reads a calibration for a pad.
pub(in crate::cli) fn correction(path: &Path, pad: &Pad) -> anyhow::Result<Correction> {
    let name = path.display();
    let text = read(path)?;
    let file: CalibrationFile = serde_json::from_str(&text).map_err(|error| {
        anyhow::anyhow!(
            "{name}: this is no calibration ({error})\n  help: `gelpad calibrate` makes one"
        )
    })?;
    if file.format != FORMAT || file.version != VERSION {
        bail!(
            "{name}: format {} version {} is not known here\n  help: calibrate again with this gelpad",
            file.format,
            file.version
        );
    }
    let correction = Correction::new(file.correction).with_context(|| name.to_string())?;
    if correction.channels() != pad.channels() {
        bail!(
            "{name}: made for the pad {} with {} channels, but {} has {}\n  help: choose its pad with --pad, or calibrate this one",
            file.pad,
            correction.channels(),
            pad.name,
            pad.channels()
        );
    }
    if file.pad != pad.name {
        bail!(
            "{name}: made for the pad {}, not {}\n  help: choose its pad with --pad, or calibrate this one",
            file.pad,
            pad.name
        );
    }
    Ok(correction)
}

/// Saves a calibration.
pub(in crate::cli) fn save(
    path: &Path,
    pad: &Pad,
    correction: &Correction,
    expected_mm: f64,
) -> anyhow::Result<()> {
    let file = CalibrationFile {
        format: FORMAT.to_owned(),
        version: VERSION,
        pad: pad.name.clone(),
        expected_mm,
        correction: correction.data().clone(),
    };
    write(path, &serde_json::to_string(&file)?)
}

/// Where a pad's calibration goes unless told: beside the pad's file, or here for a shipped one.
pub(super) fn default_path(argument: &str, pad: &Pad) -> PathBuf {
    let file = format!("{}.calibration.json", pad.name);
    if argument.contains('/') || argument.ends_with(".toml") {
        Path::new(argument).with_file_name(file)
    } else {
        PathBuf::from(file)
    }
}

/// Writes a file whole or not at all: beside its place first, then renamed.
pub(super) fn write(path: &Path, text: &str) -> anyhow::Result<()> {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    std::fs::File::create(&beside)
        .and_then(|mut file| {
            file.write_all(text.as_bytes())?;
            file.sync_all()
        })
        .and_then(|()| std::fs::rename(&beside, path))
        .with_context(|| format!("{} cannot be written", path.display()))
}

fn read(path: &Path) -> anyhow::Result<String> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(LARGEST_FILE + 1).read_to_end(&mut bytes))
        .with_context(|| path.display().to_string())?;
    if bytes.len() as u64 > LARGEST_FILE {
        bail!("{}: too large for presses or a calibration", path.display());
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(text),
        Err(_) => bail!("{}: this is no text file", path.display()),
    }
}
