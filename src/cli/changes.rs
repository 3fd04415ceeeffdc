//! Profiles that change while one plays: saved texts go live, and programs pick their own (`--match`).
//!
//! A text that cannot be used leaves the old profile in force and says why. The engine makes the switch when the outputs
//! are up, a second later at most.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use super::exit;
use super::pick::Picker;
use super::resolve;
use crate::profile::{Checked, Profile};
use crate::runtime::{Command, Running};
use crate::types::Faulty;

/// Whether a device has what a profile drives; else what it lacks.
pub(super) type Refuse = Box<dyn Fn(&Profile) -> Option<String> + Send>;

/// What may change, and what has been asked for.
pub(super) struct Changes {
    argument: String,
    user: Option<String>,
    texts: Texts,
    picker: Option<Picker>,
    refuse: Refuse,
    /// What the engine has been asked to play, and when the text was seen to have changed.
    asked: Option<(Arc<Profile>, Instant)>,
}

impl Changes {
    /// Changes of a profile that is being played.
    pub(super) fn new(
        argument: &str,
        user: Option<&str>,
        checked: &Checked,
        picker: Option<Picker>,
        refuse: Refuse,
    ) -> Self {
        Self {
            argument: argument.to_owned(),
            user: user.map(str::to_owned),
            texts: Texts::of(checked),
            picker,
            refuse,
            asked: None,
        }
    }

    /// Looks once; says what the player should know.
    pub(super) fn look(&mut self, running: &mut Running, say: &mut dyn FnMut(&str)) {
        let picked = self.picker.as_mut().and_then(Picker::look);
        if let Some(argument) = picked {
            self.argument = argument;
            self.load(running, say);
        } else if self.texts.have_changed() {
            self.load(running, say);
        }
        if let Some((profile, since)) = &self.asked
            && Arc::ptr_eq(&running.view().profile, profile)
        {
            let ms = since.elapsed().as_secs_f64() * 1e3;
            say(&format!(
                "playing {}, {ms:.0} ms after the change was seen",
                profile.name
            ));
            self.asked = None;
        }
    }

    fn load(&mut self, running: &mut Running, say: &mut dyn FnMut(&str)) {
        let now = now();
        let checked = match resolve::checked(&self.argument, self.user.as_deref()) {
            Ok(checked) => checked,
            Err(error) => return refused(&error, say),
        };
        self.texts = Texts::of(&checked);
        if let Some(lacking) = (self.refuse)(&checked.profile) {
            return say(&format!("the old profile stays: {lacking}"));
        }
        let profile = Arc::new(checked.profile);
        if running.ask(Command::Profile(Arc::clone(&profile))) {
            self.asked = Some((profile, now));
        }
    }
}

/// A mistake under the player's own line, and that the old profile stays.
fn refused(error: &anyhow::Error, say: &mut dyn FnMut(&str)) {
    match error.downcast_ref::<Faulty>() {
        Some(faulty) => say(&format!(
            "the old profile stays: {}",
            exit::drawn(faulty, miette::Severity::Error)
        )),
        None => say(&format!("the old profile stays: {error:#}")),
    }
}

#[allow(
    clippy::disallowed_methods,
    reason = "how long a saved profile takes to be played"
)]
fn now() -> Instant {
    Instant::now()
}

/// The files that a profile was read from, and what stood in them. They are read at every look: small files, and no
/// clock of a file system, no editor's way of saving and no network share can hide a change.
struct Texts {
    names: Vec<String>,
    loaded: Vec<Option<String>>,
    /// A change that was seen once: it counts when the next look finds the same, and no half-written text does.
    seen: Option<Vec<Option<String>>>,
}

impl Texts {
    fn of(checked: &Checked) -> Self {
        let names: Vec<String> = checked
            .texts
            .iter()
            .filter(|name| resolve::is_path(name))
            .cloned()
            .collect();
        Self {
            loaded: contents(&names),
            names,
            seen: None,
        }
    }

    fn have_changed(&mut self) -> bool {
        let now = contents(&self.names);
        if now == self.loaded || now.iter().any(Option::is_none) {
            self.seen = None;
            return false;
        }
        if self.seen.as_ref() != Some(&now) {
            self.seen = Some(now);
            return false;
        }
        self.loaded = now;
        self.seen = None;
        true
    }
}

fn contents(names: &[String]) -> Vec<Option<String>> {
    names
        .iter()
        .map(|name| resolve::read(Path::new(name)).ok())
        .collect()
}
