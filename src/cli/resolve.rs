//! From names to things: pads and profiles by shipped name or by path, and what a pad needs to play.

use std::io::Read as _;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, bail};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::calibrate::read_correction;
use crate::cache;
use crate::eit::Reconstruction;
use crate::pad::{Pad, SHIPPED_PADS, shipped_pad};
use crate::profile::{Profile, SHIPPED_PROFILES, shipped_profile};
use crate::touch::{Correction, SensingBuilder};
use crate::types::{Method, nearest};

/// No pad, profile or script is larger, bytes.
const LARGEST_TEXT: u64 = 1 << 20;

/// Name and text of a pad or profile.
pub(super) struct Text {
    pub name: String,
    pub toml: String,
}

/// Whether an argument means a file and not a shipped name.
fn is_path(argument: &str) -> bool {
    argument.contains('/') || argument.ends_with(".toml")
}

/// Reads a text file.
pub(super) fn read(path: &Path) -> anyhow::Result<String> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(LARGEST_TEXT + 1).read_to_end(&mut bytes))
        .with_context(|| path.display().to_string())?;
    if bytes.len() as u64 > LARGEST_TEXT {
        bail!(
            "{}: over a megabyte: this is no pad, profile or script",
            path.display()
        );
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(text),
        Err(_) => bail!("{}: this is no text file", path.display()),
    }
}

fn text(argument: &str, shipped: Option<&str>, kind: &str, names: &[&str]) -> anyhow::Result<Text> {
    let toml = match (is_path(argument), shipped) {
        (true, _) => read(Path::new(argument))?,
        (false, Some(toml)) => toml.to_owned(),
        (false, None) => {
            let guess = match nearest(argument, names.iter().copied()) {
                Some(name) => format!("did you mean `{name}`?"),
                None => format!(
                    "`gelpad {kind} list` tells the names; a file is named by a path such as ./mine.toml"
                ),
            };
            bail!("no {kind} is named `{argument}`\n  help: {guess}");
        }
    };
    Ok(Text {
        name: argument.to_owned(),
        toml,
    })
}

/// The text of a pad.
pub(super) fn pad_text(argument: &str) -> anyhow::Result<Text> {
    let names: Vec<&str> = SHIPPED_PADS.iter().map(|pad| pad.name).collect();
    text(
        argument,
        shipped_pad(argument).map(|pad| pad.toml),
        "pad",
        &names,
    )
}

/// The text of a profile.
pub(super) fn profile_text(argument: &str) -> anyhow::Result<Text> {
    let names: Vec<&str> = SHIPPED_PROFILES
        .iter()
        .map(|profile| profile.name)
        .collect();
    let shipped = shipped_profile(argument).map(|profile| profile.toml);
    text(argument, shipped, "profile", &names)
}

/// A pad, read and checked.
pub(super) fn pad(argument: &str) -> anyhow::Result<Pad> {
    let text = pad_text(argument)?;
    Ok(Pad::from_toml(&text.name, &text.toml)?)
}

/// A profile, read and checked.
pub(super) fn profile(argument: &str) -> anyhow::Result<Arc<Profile>> {
    let text = profile_text(argument)?;
    Ok(Arc::new(Profile::from_toml(&text.name, &text.toml)?))
}

/// How images are made: the command line's word, else the profile's, else the pad's, else NOSER.
pub(super) fn method(asked: Option<Method>, profile: &Profile, pad: &Pad) -> Method {
    asked.or(profile.method).or(pad.method).unwrap_or_default()
}

/// The calibration that the command line names, if it names one.
pub(super) fn correction(file: Option<&Path>, pad: &Pad) -> anyhow::Result<Option<Correction>> {
    file.map(|file| read_correction(file, pad)).transpose()
}

/// What reads a pad's frames. The first time that a pad is used its touches are solved, which is shown.
pub(super) fn sensing(pad: &Pad, method: Method) -> anyhow::Result<SensingBuilder> {
    let bar = ProgressBar::hidden();
    let progress = |done: usize, rows: usize| {
        if bar.is_hidden() {
            bar.set_length(rows as u64);
            bar.set_draw_target(ProgressDrawTarget::stderr());
            bar.set_style(solving_style());
        }
        bar.set_position(done as u64);
    };
    let builder = cache::sensing(pad, method, progress);
    bar.finish_and_clear();
    builder.with_context(|| format!("the pad {} gives no image", pad.name))
}

fn solving_style() -> ProgressStyle {
    ProgressStyle::with_template(
        "solving this pad's touches, once: {wide_bar} {percent} % {eta} left",
    )
    .unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// What makes a pad's images.
pub(super) fn reconstruction(pad: &Pad, method: Method) -> anyhow::Result<Reconstruction> {
    Reconstruction::of_pad(pad, method)
        .with_context(|| format!("the pad {} gives no image", pad.name))
}
