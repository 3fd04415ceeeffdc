//! Pads, and everything that is computed from a pad before a game starts.

use std::sync::Arc;

use super::texts::pad_text;
use super::{AppError, Progress};
use crate::cache;
use crate::eit::Reconstruction;
use crate::pad::Pad;
use crate::profile::Profile;
use crate::tape::EngineConfig;
use crate::touch::{Correction, SensingBuilder};
use crate::types::Method;

/// A pad and the text that it was parsed from.
#[derive(Clone, Debug)]
pub(crate) struct PadText {
    /// The pad.
    pub pad: Pad,
    /// Its text, as recordings store it.
    pub toml: String,
}

/// Reads a pad by shipped name or path.
pub(crate) fn load_pad(argument: &str) -> Result<PadText, AppError> {
    let text = pad_text(argument)?;
    Ok(PadText {
        pad: Pad::from_toml(&text.name, &text.toml)?,
        toml: text.toml,
    })
}

/// Reads a pad whose drawing is to be solved.
///
/// # Errors
/// See [`load_pad`]; a pad that was learned from presses, which its drawing does not describe.
pub(crate) fn load_drawn_pad(argument: &str) -> Result<PadText, AppError> {
    let pad = load_pad(argument)?;
    match &pad.pad.learned {
        None => Ok(pad),
        Some(_) => Err(AppError::Unsuitable(format!(
            "the pad {} was learned from presses: its drawing does not say how it responds\n  help: remove the table `learned` from a copy of its text to use the drawing",
            pad.pad.name
        ))),
    }
}

/// The reconstruction method: as requested, else the profile's, else the pad's, else NOSER.
pub(crate) fn choose_method(requested: Option<Method>, profile: &Profile, pad: &Pad) -> Method {
    requested
        .or(profile.method)
        .or(pad.method)
        .unwrap_or_default()
}

/// Prepares sensing. The first use of a pad solves its response table, which takes seconds; `progress` receives the
/// number of solved rows and of all rows.
pub(crate) fn sensing(
    pad: &Pad,
    method: Method,
    progress: Progress<'_>,
) -> Result<SensingBuilder, AppError> {
    start_workers()?;
    cache::sensing_builder(pad, method, progress).map_err(|error| no_image(pad, error))
}

/// Starts the threads that solve pads. Without this, a system that allows no more threads would end the program by a panic.
pub(super) fn start_workers() -> Result<(), AppError> {
    use std::error::Error as _;

    match rayon::ThreadPoolBuilder::new().build_global() {
        // The other error is that they run already.
        Err(error) if error.source().is_some() => {
            Err(AppError::Thread(std::io::Error::other(error.to_string())))
        }
        _ => Ok(()),
    }
}

/// The reconstruction matrix of a pad.
pub(crate) fn reconstruction(pad: &Pad, method: Method) -> Result<Reconstruction, AppError> {
    start_workers()?;
    Reconstruction::from_pad(pad, method).map_err(|error| no_image(pad, error))
}

/// Sensing by images only, for a game that starts before its response table is solved.
pub(super) fn sensing_by_image(pad: &Pad, method: Method) -> Result<SensingBuilder, AppError> {
    start_workers()?;
    SensingBuilder::new(pad, method).map_err(|error| no_image(pad, error))
}

/// Everything an engine starts from, and the builder of its later matrices.
pub(crate) fn engine_config(
    pad: PadText,
    profile: Arc<Profile>,
    method: Method,
    correction: Option<Correction>,
    progress: Progress<'_>,
) -> Result<(SensingBuilder, EngineConfig), AppError> {
    let builder = sensing(&pad.pad, method, progress)?;
    config_with_builder(pad, profile, correction, builder)
}

/// Everything an engine starts from, with a given builder of matrices.
pub(super) fn config_with_builder(
    PadText { pad, toml }: PadText,
    profile: Arc<Profile>,
    correction: Option<Correction>,
    builder: SensingBuilder,
) -> Result<(SensingBuilder, EngineConfig), AppError> {
    let sensing = Arc::new(
        builder
            .build_initial()
            .map_err(|error| no_image(&pad, error))?,
    );
    let locating = sensing.locator_model.as_ref();
    let config = EngineConfig {
        table: locating.map(|locating| Arc::clone(locating.table())),
        pad,
        pad_toml: toml,
        profile,
        correction,
        sensing,
    };
    Ok((builder, config))
}

pub(super) fn no_image(pad: &Pad, error: crate::eit::SetupError) -> AppError {
    AppError::NoImage {
        pad: pad.name.clone(),
        error,
    }
}
