//! Hot reload: a saved profile is played within a second, and running programs select their own profile (`--match`).
//!
//! A text with mistakes leaves the old profile in force. The engine switches when all outputs are up.

use std::fmt;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use super::outputs::OutputAbilities;
use super::process_match::ProfileMatcher;
use super::profiles::load_profile;
use super::texts::is_path;
use super::{AppError, FileWatcher, WatchedFile};
use crate::profile::Profile;
use crate::runtime::{PlayCommand, RunningGame};

/// Reloads the profile of a game.
pub(crate) struct ProfileReload {
    argument: String,
    user: Option<String>,
    /// None if every text is shipped.
    watcher: Option<FileWatcher>,
    matcher: Option<ProfileMatcher>,
    abilities: OutputAbilities,
    /// The profile that the engine was asked to play, and when its change was found.
    requested: Option<(Arc<Profile>, Instant)>,
}

/// What the player should know about a reload. Its text is one line.
#[derive(Debug)]
pub(crate) enum ReloadNotice {
    /// The changed profile is played.
    Playing { profile: String, after_ms: f64 },
    /// The text cannot be used.
    Rejected(AppError),
    /// The output lacks something that the profile drives.
    Unsupported(String),
    /// The files cannot be watched any more.
    Unwatched(io::Error),
}

impl fmt::Display for ReloadNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Playing { profile, after_ms } => {
                write!(f, "playing {profile}, {after_ms:.0} ms after the change")
            }
            Self::Rejected(error) => write!(f, "the old profile stays: {}", error.one_line()),
            Self::Unsupported(missing) => write!(f, "the old profile stays: {missing}"),
            Self::Unwatched(error) => write!(f, "saved profiles are not loaded any more: {error}"),
        }
    }
}

impl ProfileReload {
    /// Watches the texts of a profile that is being played.
    pub(super) fn start(
        argument: String,
        user: Option<String>,
        profile: &Profile,
        matcher: Option<ProfileMatcher>,
        abilities: OutputAbilities,
    ) -> io::Result<Self> {
        Ok(Self {
            argument,
            user,
            watcher: watch(profile)?,
            matcher,
            abilities,
            requested: None,
        })
    }

    /// Checks once for changes.
    pub(crate) fn poll(&mut self, running: &mut RunningGame, notify: &mut dyn FnMut(ReloadNotice)) {
        let matched = self.matcher.as_mut().and_then(ProfileMatcher::poll);
        let is_matched = matched.is_some();
        if let Some(argument) = matched {
            self.argument = argument;
        }
        // A deleted file changes nothing: some editors delete and create it when saving.
        let changes = std::iter::from_fn(|| self.watcher.as_ref()?.try_recv());
        let is_changed = changes.filter(|change| change.text.is_ok()).count() > 0;
        if (is_matched || is_changed)
            && let Err(notice) = self.load(running)
        {
            notify(notice);
        }
        if let Some((profile, since)) = &self.requested
            && Arc::ptr_eq(&running.view().profile, profile)
        {
            notify(ReloadNotice::Playing {
                profile: profile.name.clone(),
                after_ms: since.elapsed().as_secs_f64() * 1e3,
            });
            self.requested = None;
        }
    }

    fn load(&mut self, running: &mut RunningGame) -> Result<(), ReloadNotice> {
        let found_at = now();
        let checked = load_profile(&self.argument, self.user.as_deref());
        let profile = checked.map_err(ReloadNotice::Rejected)?.profile;
        self.watcher = watch(&profile).map_err(ReloadNotice::Unwatched)?;
        if let Some(missing) = self.abilities.missing_for(&profile) {
            return Err(ReloadNotice::Unsupported(missing));
        }
        let profile = Arc::new(profile);
        if running.send_command(PlayCommand::Profile(Arc::clone(&profile))) {
            self.requested = Some((profile, found_at));
        }
        Ok(())
    }
}

/// Watches the files that a profile was read from; shipped texts cannot change.
fn watch(profile: &Profile) -> io::Result<Option<FileWatcher>> {
    let texts = profile.texts.chain.iter().chain(&profile.texts.user);
    let files = texts.filter(|text| is_path(&text.name));
    let files: Vec<WatchedFile> = files
        .map(|text| WatchedFile {
            path: PathBuf::from(&text.name),
            known: Some(text.toml.clone()),
        })
        .collect();
    match files.is_empty() {
        true => Ok(None),
        false => FileWatcher::start(files, || {}).map(Some),
    }
}

#[allow(
    clippy::disallowed_methods,
    reason = "measures how long a saved profile takes to be played"
)]
fn now() -> Instant {
    Instant::now()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rejected_profile_is_reported_in_one_line() {
        let toml = "schema = 1\nname = \"p\"\nmode = 1\nlevel = 2\n";
        let errors = Profile::from_toml("./live.toml", toml).expect_err("two mistakes");
        let text = ReloadNotice::Rejected(AppError::Text(errors)).to_string();
        let start = "the old profile stays: ./live.toml:3:1: ";
        assert!(
            text.starts_with(start) && text.lines().count() == 1,
            "{text}"
        );
    }
}
