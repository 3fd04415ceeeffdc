//! The user's own folder: profiles, users, pads and calibrations.

use std::path::PathBuf;

/// `gelpad` in the configuration folder, for example `~/.config/gelpad`. None without a home folder.
pub(crate) fn own_folder() -> Option<PathBuf> {
    directories::BaseDirs::new().map(|folders| folders.config_dir().join("gelpad"))
}

/// `gelpad/recordings` in the data folder, for example `~/.local/share/gelpad/recordings`. None without a home folder.
pub(crate) fn recordings_folder() -> Option<PathBuf> {
    directories::BaseDirs::new().map(|folders| folders.data_dir().join("gelpad/recordings"))
}

/// Paths of the user's own texts of a kind (`profiles`, `pads`, `users`), sorted.
pub(crate) fn own_texts(kind: &str) -> Vec<String> {
    let Some(entries) = own_folder().and_then(|folder| std::fs::read_dir(folder.join(kind)).ok())
    else {
        return Vec::new();
    };
    let mut files: Vec<String> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .map(|path| path.display().to_string())
        .collect();
    files.sort();
    files
}
