//! What is held down, on disk: one small file for each watcher of a display that keeps what a killed client held (X11).
//!
//! ```text
//! display :0
//! parent 4711
//! key:f
//! ```
//! A watcher locks its file while it lives. A file without a lock was left by a watcher that was killed together with its
//! gelpad: the next gelpad on the display releases its outputs. A locked one shows what another gelpad holds, which the end
//! of this one must not release. A watcher whose gelpad has ended adds the line `ended`: its outputs protect nothing any
//! more, so that two that end at the same time do not wait for each other.

use std::fs::{self, File};
use std::io::{self, Seek as _, Write as _};
use std::path::{Path, PathBuf};

use crate::output::HeldOutputs;
use crate::platform::system::processes::is_running;
use crate::platform::system::watch::held_files;
use crate::types::Output;

/// A longer file is not ours.
const MOST_BYTES: u64 = 16_384;

/// The file of one watcher; dropping it removes it.
pub(in crate::platform) struct StateFile {
    folder: PathBuf,
    path: PathBuf,
    file: File,
    state: HeldState,
}

/// The content of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct HeldState {
    display: String,
    parent: i32,
    has_ended: bool,
    held: Vec<Output>,
}

impl HeldState {
    fn to_text(&self) -> String {
        let mut text = format!("display {}\nparent {}\n", self.display, self.parent);
        if self.has_ended {
            text.push_str("ended\n");
        }
        for output in &self.held {
            text.push_str(&format!("{output}\n"));
        }
        text
    }

    /// Lines that are nothing known are skipped: a killed writer may leave half of one.
    fn from_text(text: &str) -> Self {
        let mut state = Self::default();
        for line in text.lines() {
            match line.split_once(' ') {
                Some(("display", name)) => state.display = name.to_owned(),
                Some(("parent", pid)) => state.parent = pid.parse().unwrap_or(0),
                _ if line == "ended" => state.has_ended = true,
                _ => state.held.extend(line.parse::<Output>()),
            }
        }
        state
    }
}

/// The folder of the files: the user's runtime folder, which is emptied at logout, or else the cache.
pub(in crate::platform) fn folder() -> Option<PathBuf> {
    let folders = directories::BaseDirs::new()?;
    let base = folders.runtime_dir().unwrap_or(folders.cache_dir());
    Some(base.join("gelpad").join("held"))
}

impl StateFile {
    /// Creates the file of this process in a folder.
    pub(in crate::platform) fn create(
        folder: &Path,
        display: &str,
        parent: i32,
    ) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let path = folder.join(format!("{}.txt", std::process::id()));
        // Remains of a process with the same number; a link is removed, not followed.
        let _ = fs::remove_file(&path);
        let file = File::create_new(&path)?;
        held_files::claim(&file)?;
        let state = HeldState {
            display: display.to_owned(),
            parent,
            ..HeldState::default()
        };
        let mut created = Self {
            folder: folder.to_owned(),
            path,
            file,
            state,
        };
        created.write()?;
        Ok(created)
    }

    /// Records what is down.
    pub(in crate::platform) fn set(&mut self, held: &HeldOutputs, has_ended: bool) {
        let held: Vec<Output> = held.iter().collect();
        if held == self.state.held && has_ended == self.state.has_ended {
            return;
        }
        self.state.held = held;
        self.state.has_ended = has_ended;
        // It only helps if everything else is killed.
        if let Err(error) = self.write() {
            tracing::debug!("{}: {error}", self.path.display());
        }
    }

    fn write(&mut self) -> io::Result<()> {
        let text = self.state.to_text();
        self.file.rewind()?;
        self.file.write_all(text.as_bytes())?;
        self.file.set_len(text.len() as u64)
    }

    /// What other gelpads hold on the same display.
    pub(in crate::platform) fn held_by_others(&self) -> HeldOutputs {
        let mut held = HeldOutputs::default();
        for (_, state, is_alive) in self.others() {
            if is_alive && !state.has_ended && state.parent != self.state.parent {
                state.held.into_iter().for_each(|output| held.press(output));
            }
        }
        held
    }

    /// What killed gelpads have left down on this display, each with its file, to be removed when the outputs are up. What
    /// killed watchers of the own gelpad noted belongs to it once that gelpad has ended, too.
    pub(in crate::platform) fn left_down(
        &self,
        parent_has_ended: bool,
    ) -> Vec<(PathBuf, HeldOutputs)> {
        let others = self.held_by_others();
        let mut left = Vec::new();
        for (path, state, is_alive) in self.others() {
            let parent_is_alive = match state.parent == self.state.parent {
                true => !parent_has_ended,
                // It has another watcher, or starts one just now.
                false => is_running(state.parent),
            };
            if is_alive || parent_is_alive {
                continue;
            }
            let mut held = HeldOutputs::default();
            state.held.into_iter().for_each(|output| held.press(output));
            others.iter().for_each(|output| held.release(output));
            left.push((path, held));
        }
        left
    }

    /// Path, content and whether the watcher lives, of each other file of this display.
    fn others(&self) -> Vec<(PathBuf, HeldState, bool)> {
        let entries = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
        paths.sort();
        paths.retain(|path| *path != self.path);
        let read = paths.into_iter().filter_map(|path| {
            let is_file = path.symlink_metadata().ok()?;
            if !is_file.is_file() || is_file.len() > MOST_BYTES {
                return None;
            }
            let text = fs::read_to_string(&path).ok()?;
            let state = HeldState::from_text(&text);
            let is_alive = held_files::is_claimed(&path)?;
            (state.display == self.state.display).then_some((path, state, is_alive))
        });
        read.collect()
    }
}

impl Drop for StateFile {
    fn drop(&mut self) {
        remove(&self.path);
    }
}

/// Removes a file whose outputs are up.
pub(in crate::platform) fn remove(path: &Path) {
    // Another gelpad may have removed it.
    let _ = fs::remove_file(path);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number that no process has.
    const NOBODY: i32 = i32::MAX;

    fn held(names: &[&str]) -> HeldOutputs {
        let mut held = HeldOutputs::default();
        for name in names {
            held.press(name.parse().expect("an output"));
        }
        held
    }

    fn leave(folder: &Path, name: &str, parent: i32, held: &[&str]) -> PathBuf {
        let path = folder.join(name);
        let text = format!("display :9\nparent {parent}\n{}\nke", held.join("\n"));
        fs::write(&path, text).expect("written");
        path
    }

    #[test]
    fn what_killed_gelpads_left_is_found_once_and_for_the_same_display() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let own = StateFile::create(folder, ":9", NOBODY - 1).expect("created");
        let left = leave(folder, "1.txt", NOBODY, &["key:f", "mouse:left"]);
        leave(folder, "2.txt", std::process::id() as i32, &["key:a"]);
        let elsewhere = format!("display :8\nparent {NOBODY}\nkey:c\n");
        fs::write(folder.join("4.txt"), elsewhere).expect("written");
        let found = own.left_down(false);
        assert_eq!(found, [(left.clone(), held(&["key:f", "mouse:left"]))]);
        remove(&left);
        assert_eq!(own.left_down(false), []);
        // A killed watcher of the own gelpad.
        leave(folder, "3.txt", NOBODY - 1, &["key:b"]);
        assert_eq!(own.left_down(false), []);
        assert_eq!(own.left_down(true)[0].1, held(&["key:b"]));
    }

    #[test]
    fn what_another_gelpad_holds_is_not_released_until_it_ends() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let own = StateFile::create(&folder.join("x"), ":9", NOBODY - 1).expect("created");
        let own = StateFile {
            folder: folder.to_owned(),
            path: own.path.clone(),
            file: own.file.try_clone().expect("a file"),
            state: own.state.clone(),
        };
        let mut other = StateFile::create(folder, ":9", NOBODY - 2).expect("created");
        other.set(&held(&["key:f"]), false);
        leave(folder, "1.txt", NOBODY, &["key:f", "key:d"]);
        assert_eq!(own.held_by_others(), held(&["key:f"]));
        assert_eq!(own.left_down(false)[0].1, held(&["key:d"]));
        other.set(&held(&["key:f"]), true);
        assert_eq!(own.held_by_others(), held(&[]));
    }
}
