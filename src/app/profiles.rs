//! Profiles with the bases that they extend and one user's settings, read and checked.

use std::path::Path;

use super::AppError;
use super::texts::{is_path, profile_text, read_text, user_text};
use crate::profile::{self, Checked, Profile, Source, find_shipped};
use crate::types::SourceErrors;

/// Reads a profile with one user's settings over it.
pub(crate) fn load_profile(argument: &str, user: Option<&str>) -> Result<Checked, AppError> {
    let user = user.map(user_text).transpose()?;
    Ok(check(profile_text(argument)?, user)?)
}

/// Checks a text that is not saved yet; its name is the file's. Unknown users are ignored: starting a game reports them.
pub(crate) fn check_text(profile: Source, user: Option<&str>) -> Result<Checked, SourceErrors> {
    check(profile, user.and_then(|user| user_text(user).ok()))
}

/// A loaded profile with another user's settings.
pub(crate) fn with_user(profile: &Profile, user: Option<&str>) -> Result<Profile, AppError> {
    let mut texts = profile.texts.clone();
    texts.user = user.map(user_text).transpose()?;
    Ok(texts.read()?.profile)
}

fn check(profile: Source, user: Option<Source>) -> Result<Checked, SourceErrors> {
    let find = bases_of(&profile.name);
    profile::read(profile, user, &find)
}

/// Finds the texts that a profile extends: shipped ones by name, files relative to the profile's folder.
pub(crate) fn bases_of(profile: &str) -> impl Fn(&str) -> Result<Source, String> + use<> {
    let folder = Path::new(profile)
        .parent()
        .unwrap_or(Path::new(""))
        .to_owned();
    move |name: &str| {
        if !is_path(name) {
            return find_shipped(name);
        }
        let path = folder.join(name);
        let toml = read_text(&path).map_err(|error| error.to_string())?;
        Ok(Source {
            name: path.display().to_string(),
            toml,
        })
    }
}
