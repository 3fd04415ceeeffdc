//! Files of the player: recordings and own texts, listed, renamed and deleted.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// A file in a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnFile {
    /// Its path.
    pub path: PathBuf,
    /// Its size, bytes.
    pub bytes: u64,
    /// When it was written last.
    pub modified: Option<SystemTime>,
}

/// The files of a folder with an extension, the newest first; none if there is no such folder.
#[must_use]
pub fn list(folder: &Path, extension: &str) -> Vec<OwnFile> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let has_extension = |path: &PathBuf| path.extension().is_some_and(|own| own == extension);
    let mut files: Vec<OwnFile> = entries
        .map(|entry| entry.path())
        .filter(has_extension)
        .filter_map(|path| {
            let data = std::fs::metadata(&path)
                .ok()
                .filter(|data| data.is_file())?;
            Some(OwnFile {
                path,
                bytes: data.len(),
                modified: data.modified().ok(),
            })
        })
        .collect();
    files.sort_by(|a, b| (b.modified, &a.path).cmp(&(a.modified, &b.path)));
    files
}

/// Why a name cannot be that of a file; none if it can.
#[must_use]
pub fn name_problem(name: &str) -> Option<String> {
    if name.trim().is_empty() {
        return Some("enter a name".to_owned());
    }
    let wrong = name
        .chars()
        .find(|c| "/\\:*?\"<>|".contains(*c) || c.is_control())?;
    Some(format!("a name cannot contain {wrong:?}"))
}

/// Gives a file another name in its folder and keeps its extension. No file is replaced.
///
/// # Errors
/// A name that is taken or no name, or a folder that cannot be written.
pub fn rename(path: &Path, name: &str) -> Result<PathBuf, String> {
    let name = name.trim();
    if let Some(problem) = name_problem(name) {
        return Err(problem);
    }
    let mut file = name.to_owned();
    if let Some(extension) = path.extension().and_then(|own| own.to_str()) {
        file = format!("{file}.{extension}");
    }
    let renamed = path.with_file_name(file);
    if renamed.exists() {
        return Err(format!("there is already a file named {name}"));
    }
    let moved = std::fs::rename(path, &renamed);
    moved.map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(renamed)
}

/// Deletes a file.
///
/// # Errors
/// It cannot be deleted.
pub fn delete(path: &Path) -> Result<(), String> {
    std::fs::remove_file(path).map_err(|error| format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_listed_renamed_without_replacing_and_deleted() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = |name: &str| folder.path().join(name);
        for name in ["a.mcap", "b.mcap", "notes.txt"] {
            std::fs::write(file(name), name).expect("written");
        }
        assert_eq!(list(folder.path(), "mcap").len(), 2);
        assert!(rename(&file("a.mcap"), "b").is_err(), "taken");
        assert!(rename(&file("a.mcap"), "x/y").is_err());
        let renamed = rename(&file("a.mcap"), " level 1.2 ").expect("renamed");
        assert_eq!(renamed, file("level 1.2.mcap"));
        delete(&renamed).expect("deleted");
        let left = list(folder.path(), "mcap");
        assert_eq!(left.len(), 1);
        assert_eq!((left[0].path.clone(), left[0].bytes), (file("b.mcap"), 6));
        assert!(list(&file("missing"), "mcap").is_empty());
    }
}
