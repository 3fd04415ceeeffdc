//! Texts of pads, profiles and users, by shipped name or by path.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use super::AppError;
use super::folders::{own_folder, own_texts};
use crate::pad::{SHIPPED_PADS, shipped_pad};
use crate::profile::{
    SHIPPED_PROFILES, SHIPPED_USERS, ShippedProfile, Source, shipped_profile, shipped_user,
};
use crate::types::nearest;

/// Limit for pads, profiles and scripts, bytes.
const MAX_TEXT_BYTES: u64 = 1 << 20;

/// Whether an argument is a path and not a shipped name: it holds `/` or `\`, begins with a drive (`C:`), or ends in `.toml`.
pub(crate) fn is_path(argument: &str) -> bool {
    let has_drive =
        matches!(argument.as_bytes(), [letter, b':', ..] if letter.is_ascii_alphabetic());
    argument.contains(['/', '\\']) || has_drive || argument.ends_with(".toml")
}

/// A path as `--pad` takes it: names without a slash that do not end in `.toml` are those of shipped pads.
pub(crate) fn as_pad_argument(path: &Path) -> String {
    match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => format!("./{}", path.display()),
        _ => path.display().to_string(),
    }
}

/// Reads a pad, profile or script.
pub(crate) fn read_text(path: &Path) -> Result<String, AppError> {
    read_limited(path, MAX_TEXT_BYTES)
}

/// Reads a text file of at most `max_bytes`.
pub(crate) fn read_limited(path: &Path, max_bytes: u64) -> Result<String, AppError> {
    let content_error = |reason: String| AppError::Content {
        path: path.to_owned(),
        reason,
    };
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(max_bytes + 1).read_to_end(&mut bytes))
        .map_err(|error| AppError::Read {
            path: path.to_owned(),
            error,
        })?;
    if bytes.len() as u64 > max_bytes {
        return Err(content_error(format!(
            "larger than {} MB: not the expected kind of file",
            max_bytes >> 20
        )));
    }
    String::from_utf8(bytes).map_err(|_| content_error("not a text file".to_owned()))
}

/// The text of a pad.
pub(crate) fn pad_text(argument: &str) -> Result<Source, AppError> {
    let shipped = shipped_pad(argument).map(|pad| pad.toml);
    find_text(
        argument,
        "pad",
        shipped,
        SHIPPED_PADS.iter().map(|pad| pad.name),
    )
}

/// The text of a profile.
pub(crate) fn profile_text(argument: &str) -> Result<Source, AppError> {
    let shipped = shipped_profile(argument).map(|profile| profile.toml);
    let names = SHIPPED_PROFILES.iter().map(|profile| profile.name);
    find_text(argument, "profile", shipped, names)
}

/// The file of a profile in the user's own folder, for a name that no shipped profile has; other arguments stay as they are.
pub(crate) fn own_or_given_profile(argument: &str) -> String {
    if is_path(argument) || shipped_profile(argument).is_some() {
        return argument.to_owned();
    }
    own_file("profiles", argument).unwrap_or_else(|| argument.to_owned())
}

/// Names of the user's own texts of a kind (`profiles`, `pads`, `users`).
fn own_names(folder: &str) -> Vec<String> {
    let paths = own_texts(folder).into_iter();
    let stem = |path: String| Some(Path::new(&path).file_stem()?.to_str()?.to_owned());
    paths.filter_map(stem).collect()
}

/// The path of the user's own text of a kind (`profiles`, `pads`).
fn own_file(folder: &str, name: &str) -> Option<String> {
    let path = own_folder()?.join(folder).join(format!("{name}.toml"));
    path.is_file().then(|| path.display().to_string())
}

fn find_text(
    argument: &str,
    kind: &'static str,
    shipped: Option<&str>,
    names: impl Iterator<Item = &'static str>,
) -> Result<Source, AppError> {
    let folder = format!("{kind}s");
    let own = match is_path(argument) || shipped.is_some() {
        true => None,
        false => own_file(&folder, argument),
    };
    let argument = own.as_deref().unwrap_or(argument);
    let toml = match (is_path(argument), shipped) {
        (true, _) => read_text(Path::new(argument))?,
        (false, Some(toml)) => toml.to_owned(),
        (false, None) => {
            let own = own_names(&folder);
            let mut known: Vec<&str> = names.collect();
            known.extend(own.iter().map(String::as_str));
            let help = match nearest(argument, known.into_iter()) {
                Some(name) => format!("did you mean `{name}`?"),
                None => format!(
                    "`gelpad {kind} list` prints the names; write a file as a path, such as ./mine.toml"
                ),
            };
            return Err(AppError::UnknownName {
                kind,
                name: argument.to_owned(),
                help,
            });
        }
    };
    Ok(Source {
        name: argument.to_owned(),
        toml,
    })
}

/// A user's settings: a path, or a name that is looked up in `users/` here, in the user's own folder, and among the
/// shipped ones.
pub(crate) fn user_text(argument: &str) -> Result<Source, AppError> {
    if is_path(argument) {
        return Ok(Source {
            name: argument.to_owned(),
            toml: read_text(Path::new(argument))?,
        });
    }
    let file = Path::new("users").join(format!("{argument}.toml"));
    let own = own_folder().map(|folder| folder.join(&file));
    for path in std::iter::once(file).chain(own) {
        if path.is_file() {
            return Ok(Source {
                name: path.display().to_string(),
                toml: read_text(&path)?,
            });
        }
    }
    match shipped_user(argument) {
        Some(ShippedProfile { name, toml }) => Ok(Source {
            name: (*name).to_owned(),
            toml: (*toml).to_owned(),
        }),
        None => Err(unknown_user(argument)),
    }
}

fn unknown_user(argument: &str) -> AppError {
    let mut known = own_names("users");
    // A file of one's own comes before a shipped one of the same name.
    for user in SHIPPED_USERS {
        if !known.iter().any(|own| own == user.name) {
            known.push(user.name.to_owned());
        }
    }
    let help = match nearest(argument, known.iter().map(String::as_str)) {
        Some(name) => format!("did you mean `{name}`?"),
        None => format!("write users/{argument}.toml, here or in your own gelpad folder"),
    };
    AppError::UnknownUser {
        name: argument.to_owned(),
        known,
        help,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_of_every_system_are_recognised() {
        for path in ["./mine", r".\mine", r"C:\pads\mine", "c:mine", "mine.toml"] {
            assert!(is_path(path), "{path}");
        }
        for name in ["super-mario", "edinburgh-lattice", "4:3", ""] {
            assert!(!is_path(name), "{name}");
        }
    }
}
