//! The machine that is looked at: its files and its settings. Tests look at folders that stand for one.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Where the files of a machine lie, and what its settings are.
#[derive(Clone, Debug)]
pub struct Machine {
    root: PathBuf,
    settings: BTreeMap<String, String>,
}

impl Machine {
    /// This one.
    #[must_use]
    pub fn here() -> Self {
        let text = |text: std::ffi::OsString| text.into_string().ok();
        Self {
            root: PathBuf::from("/"),
            settings: std::env::vars_os()
                .filter_map(|(name, value)| Some((text(name)?, text(value)?)))
                .collect(),
        }
    }

    /// One whose files lie under a folder.
    #[must_use]
    pub fn under(root: &Path, settings: &[(&str, &str)]) -> Self {
        let own = |(name, value): &(&str, &str)| ((*name).to_owned(), (*value).to_owned());
        Self {
            root: root.to_owned(),
            settings: settings.iter().map(own).collect(),
        }
    }

    /// Where an absolute path lies.
    pub(super) fn path(&self, path: &str) -> PathBuf {
        self.root.join(path.trim_start_matches('/'))
    }

    pub(super) fn exists(&self, path: &str) -> bool {
        self.path(path).exists()
    }

    /// A file's text, without the line's end; none if it cannot be read.
    pub(super) fn text(&self, path: &str) -> Option<String> {
        let text = fs::read_to_string(self.path(path)).ok()?;
        Some(text.trim_end().to_owned())
    }

    /// Names in a folder, sorted; none if there is no such folder.
    pub(super) fn names(&self, path: &str) -> Vec<String> {
        let Ok(entries) = fs::read_dir(self.path(path)) else {
            return Vec::new();
        };
        let mut names: Vec<String> = entries
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .collect();
        names.sort();
        names
    }

    /// A setting of the environment that is not empty.
    pub(super) fn setting(&self, name: &str) -> Option<&str> {
        let value = self.settings.get(name).map(String::as_str);
        value.filter(|value| !value.is_empty())
    }

    /// The name of a user or group by number, from `/etc/passwd` or `/etc/group`.
    pub(super) fn name_of(&self, file: &str, id: u32) -> String {
        let table = self.text(file).unwrap_or_default();
        let named = table.lines().find_map(|line| {
            let mut fields = line.split(':');
            let name = fields.next()?;
            (fields.nth(1)?.parse::<u32>().ok()? == id).then(|| name.to_owned())
        });
        named.unwrap_or_else(|| id.to_string())
    }
}
