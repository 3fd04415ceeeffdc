//! Profiles with unsaved changes that are not shown now: kept until they are shown again, saved, or given up on closing.

use super::file::OpenProfile;

/// The kept profiles, at most one per file.
#[derive(Default)]
pub(super) struct Drafts(Vec<OpenProfile>);

impl Drafts {
    /// Keeps a profile if it has unsaved changes.
    pub(super) fn keep(&mut self, profile: Option<OpenProfile>) {
        self.0.extend(profile.filter(OpenProfile::is_unsaved));
    }

    /// Takes out the profile of a name or path.
    pub(super) fn take(&mut self, argument: &str) -> Option<OpenProfile> {
        let index = self.0.iter().position(|one| one.argument == argument)?;
        Some(self.0.swap_remove(index))
    }

    /// Names or paths of the kept profiles.
    pub(super) fn arguments(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|one| one.argument.as_str())
    }

    /// The kept profiles.
    pub(super) fn all_mut(&mut self) -> impl Iterator<Item = &mut OpenProfile> {
        self.0.iter_mut()
    }
}
