//! The folder of a study: `study.json` (the settings), `cases/ID.json` (the result of each case), and the report.
//!
//! The report is made from the settings and the results alone. So a resumed study, and shards that are merged, end with
//! the same files as one unbroken run.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::StudyError;

/// The file of a finished case.
#[derive(Deserialize, Serialize)]
struct StoredCase<R> {
    /// The settings for which it was solved: a result of another study is ignored.
    study: String,
    result: R,
}

/// The folder of a study.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
    study: String,
}

impl Folder {
    /// Opens or creates the folder of the study with these settings.
    ///
    /// # Errors
    /// A folder that cannot be read or written, or that holds another study.
    pub fn open(path: &Path, settings: &impl Serialize) -> Result<Self, StudyError> {
        let study = serde_json::to_string_pretty(settings).map_err(StudyError::internal)?;
        let folder = Self {
            path: path.to_owned(),
            study,
        };
        let cases = path.join("cases");
        fs::create_dir_all(&cases).map_err(|error| StudyError::file(&cases, error))?;
        match Self::settings_text(path) {
            Ok(other) if other != folder.study => Err(StudyError::refused(format!(
                "{} holds another study: choose another --out",
                path.display()
            ))),
            Ok(_) => Ok(folder),
            Err(StudyError::File { error, .. }) if error.kind() == ErrorKind::NotFound => {
                folder.write("study.json", folder.study.as_bytes())?;
                Ok(folder)
            }
            Err(error) => Err(error),
        }
    }

    /// The text of `study.json` in a folder.
    ///
    /// # Errors
    /// A file that is missing or cannot be read.
    pub fn settings_text(path: &Path) -> Result<String, StudyError> {
        let manifest = path.join("study.json");
        fs::read_to_string(&manifest).map_err(|error| StudyError::file(&manifest, error))
    }

    /// Whether a folder holds the study whose settings have this text.
    ///
    /// # Errors
    /// Another study; settings that cannot be read.
    pub fn check_settings(path: &Path, settings: &str) -> Result<(), StudyError> {
        if Self::settings_text(path)? == settings {
            return Ok(());
        }
        Err(StudyError::refused(format!(
            "{} holds another study than the first folder",
            path.display()
        )))
    }

    /// The folder's path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file into the folder with [`write_whole`].
    ///
    /// # Errors
    /// A disk that is full or read-only.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StudyError> {
        write_whole(&self.path, name, bytes)
    }

    fn case_name(id: &str) -> String {
        format!("cases/{id}.json")
    }

    /// The stored result of a case; `None` if there is none, or one of another study.
    #[must_use]
    pub fn stored_result<R: DeserializeOwned>(&self, id: &str) -> Option<R> {
        let text = fs::read(self.path.join(Self::case_name(id))).ok()?;
        let stored: StoredCase<R> = serde_json::from_slice(&text).ok()?;
        (stored.study == self.study).then_some(stored.result)
    }

    /// Stores the result of a case.
    ///
    /// # Errors
    /// A disk that is full or read-only.
    pub(super) fn store_result<R: Serialize>(
        &self,
        id: &str,
        result: &R,
    ) -> Result<(), StudyError> {
        let study = self.study.clone();
        let text =
            serde_json::to_vec(&StoredCase { study, result }).map_err(StudyError::internal)?;
        self.write(&Self::case_name(id), &text)
    }

    /// Copies the results from another folder of the same study.
    ///
    /// # Errors
    /// A folder that holds another study, or cannot be read; a disk that is full or read-only.
    pub fn copy_results_from(&self, other: &Path) -> Result<(), StudyError> {
        Self::check_settings(other, &self.study)?;
        let cases = other.join("cases");
        let unreadable = |error| StudyError::file(&cases, error);
        for entry in fs::read_dir(&cases).map_err(unreadable)? {
            let path = entry.map_err(unreadable)?.path();
            if path
                .extension()
                .is_some_and(|extension| extension == "json")
                && let Some(name) = path.file_name().and_then(|name| name.to_str())
            {
                let bytes = fs::read(&path).map_err(|error| StudyError::file(&path, error))?;
                self.write(&format!("cases/{name}"), &bytes)?;
            }
        }
        Ok(())
    }
}

/// Writes a file whole or not at all: to a temporary name in the same folder, then renamed.
///
/// # Errors
/// A disk that is full or read-only.
pub fn write_whole(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), StudyError> {
    let path = folder.join(name);
    let part = path.with_extension("part");
    fs::write(&part, bytes)
        .and_then(|()| fs::rename(&part, &path))
        .map_err(|error| StudyError::file(&path, error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_of_another_study_is_refused() {
        let root = tempfile::tempdir().expect("a folder");
        Folder::open(root.path(), &"one").expect("opened");
        let error = Folder::open(root.path(), &"two").expect_err("another study");
        assert!(error.to_string().contains("holds another study"), "{error}");
    }

    #[test]
    fn unreadable_settings_are_reported_and_not_overwritten() {
        let root = tempfile::tempdir().expect("a folder");
        let manifest = root.path().join("study.json");
        let not_utf8 = [b'"', 0xff, b'"'];
        fs::write(&manifest, not_utf8).expect("written");
        let error = Folder::open(root.path(), &"one").expect_err("unreadable");
        assert!(error.to_string().contains("study.json"), "{error}");
        assert_eq!(fs::read(&manifest).expect("still there"), not_utf8);
    }
}
