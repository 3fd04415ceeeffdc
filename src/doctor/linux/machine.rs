//! The machine under examination: its files and environment. Tests use a folder in place of `/`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Root folder and environment variables of a machine.
#[derive(Clone, Debug)]
pub struct Machine {
    root: PathBuf,
    environment: BTreeMap<String, String>,
}

impl Machine {
    /// This machine.
    #[must_use]
    pub fn local() -> Self {
        let text = |text: std::ffi::OsString| text.into_string().ok();
        Self {
            root: PathBuf::from("/"),
            environment: std::env::vars_os()
                .filter_map(|(name, value)| Some((text(name)?, text(value)?)))
                .collect(),
        }
    }

    /// A machine whose files are under a folder.
    #[must_use]
    pub fn at_root(root: &Path, environment: &[(&str, &str)]) -> Self {
        let own = |(name, value): &(&str, &str)| ((*name).to_owned(), (*value).to_owned());
        Self {
            root: root.to_owned(),
            environment: environment.iter().map(own).collect(),
        }
    }

    /// Path of a file of the machine; `path` is absolute.
    pub(super) fn path(&self, path: &str) -> PathBuf {
        self.root.join(path.trim_start_matches('/'))
    }

    pub(super) fn exists(&self, path: &str) -> bool {
        self.path(path).exists()
    }

    /// Text of a file without trailing whitespace; `None` if it cannot be read.
    pub(super) fn text(&self, path: &str) -> Option<String> {
        let text = fs::read_to_string(self.path(path)).ok()?;
        Some(text.trim_end().to_owned())
    }

    /// Sorted names in a folder; empty if the folder cannot be read.
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

    /// An environment variable that is set and not empty.
    pub(super) fn variable(&self, name: &str) -> Option<&str> {
        let value = self.environment.get(name).map(String::as_str);
        value.filter(|value| !value.is_empty())
    }

    /// Name of a user or group, from `/etc/passwd` or `/etc/group`; its number if it has none.
    pub(super) fn account_name(&self, file: &str, id: u32) -> String {
        let table = self.text(file).unwrap_or_default();
        let named = table.lines().find_map(|line| {
            let mut fields = line.split(':');
            let name = fields.next()?;
            (fields.nth(1)?.parse::<u32>().ok()? == id).then(|| name.to_owned())
        });
        named.unwrap_or_else(|| id.to_string())
    }
}
