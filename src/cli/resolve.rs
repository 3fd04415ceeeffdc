//! From names to things: pads and profiles by shipped name or by path, and what a pad needs to play.

use std::io::{IsTerminal as _, Read as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, bail};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::calibrate::read_correction;
use super::exit;
use crate::cache;
use crate::eit::Reconstruction;
use crate::pad::{Pad, SHIPPED_PADS, shipped_pad};
use crate::profile::{
    self, Checked, Profile, SHIPPED_PROFILES, SHIPPED_USERS, Source, find_shipped, shipped_profile,
    shipped_user,
};
use crate::touch::{Correction, SensingBuilder};
use crate::types::{Faulty, Method, nearest};

/// No pad, profile or script is larger, bytes.
const LARGEST_TEXT: u64 = 1 << 20;

/// Name and text of a pad or profile.
pub(super) struct Text {
    pub name: String,
    pub toml: String,
}

impl From<Text> for Source {
    fn from(text: Text) -> Self {
        Self {
            name: text.name,
            toml: text.toml,
        }
    }
}

/// Whether an argument means a file and not a shipped name.
pub(super) fn is_path(argument: &str) -> bool {
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

/// A profile with one person's settings, read and checked; what is odd about it is told.
pub(super) fn profile(argument: &str, user: Option<&str>) -> anyhow::Result<Arc<Profile>> {
    let checked = checked(argument, user)?;
    checked.warnings.iter().for_each(exit::warn);
    Ok(Arc::new(checked.profile))
}

/// A profile that is there already, with another person's settings.
pub(super) fn with_user(profile: &Profile, user: Option<&str>) -> anyhow::Result<Arc<Profile>> {
    let mut texts = profile.texts.clone();
    texts.user = user.map(self::user).transpose()?;
    Ok(Arc::new(texts.read()?.profile))
}

/// A profile with one person's settings, and what is odd about it.
pub(super) fn checked(argument: &str, user: Option<&str>) -> anyhow::Result<Checked> {
    let user = user.map(self::user).transpose()?;
    Ok(checked_over(profile_text(argument)?.into(), user)?)
}

/// The same for a text that is not saved yet; its name is the file's.
#[cfg(feature = "gui")]
pub(super) fn checked_text(profile: Source, user: Option<&str>) -> Result<Checked, Faulty> {
    // A person who is not found is told of when the game starts.
    checked_over(profile, user.and_then(|user| self::user(user).ok()))
}

fn checked_over(profile: Source, user: Option<Source>) -> Result<Checked, Faulty> {
    let find = bases_of(&profile.name);
    profile::read(profile, user, &find)
}

/// Finds what a profile extends: shipped ones by name, files beside it.
pub(super) fn bases_of(profile: &str) -> impl Fn(&str) -> Result<Source, String> + use<> {
    let folder = Path::new(profile)
        .parent()
        .unwrap_or(Path::new(""))
        .to_owned();
    move |name: &str| {
        if !is_path(name) {
            return find_shipped(name);
        }
        let path = folder.join(name);
        let toml = read(&path).map_err(|error| format!("{error:#}"))?;
        Ok(Source {
            name: path.display().to_string(),
            toml,
        })
    }
}

/// A person's text: a file, or a name that is looked for here, among one's own, and among the shipped.
fn user(argument: &str) -> anyhow::Result<Source> {
    if is_path(argument) {
        return Ok(Source {
            name: argument.to_owned(),
            toml: read(Path::new(argument))?,
        });
    }
    let file = Path::new("users").join(format!("{argument}.toml"));
    let own = own_folder().map(|folder| folder.join(&file));
    for path in std::iter::once(file).chain(own) {
        if path.is_file() {
            return Ok(Source {
                name: path.display().to_string(),
                toml: read(&path)?,
            });
        }
    }
    if let Some(shipped) = shipped_user(argument) {
        return Ok(Source {
            name: shipped.name.to_owned(),
            toml: shipped.toml.to_owned(),
        });
    }
    let names = SHIPPED_USERS.iter().map(|user| user.name);
    let guess = match nearest(argument, names) {
        Some(name) => format!("did you mean `{name}`?"),
        None => format!("write users/{argument}.toml, here or in your own gelpad folder"),
    };
    bail!("nobody is named `{argument}`\n  help: {guess}");
}

/// Where a player's own profiles and users lie: `gelpad` in the folder for settings.
pub(super) fn own_folder() -> Option<PathBuf> {
    let folder = |name: &str| {
        std::env::var_os(name)
            .filter(|value| !value.is_empty())
            .map(PathBuf::from)
    };
    let settings = folder("XDG_CONFIG_HOME")
        .or_else(|| folder("APPDATA"))
        .or_else(|| folder("HOME").map(|home| home.join(".config")));
    settings.map(|settings| settings.join("gelpad"))
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
            if !std::io::stderr().is_terminal() && done == 1 {
                tracing::warn!(
                    "solving the touches of the pad {}, once: some seconds",
                    pad.name
                );
            }
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
