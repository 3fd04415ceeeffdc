//! Processes of this computer.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use rustix::process::{Pid, test_kill_process};

/// Linux cuts names of processes to this length.
const MAX_NAME_BYTES: usize = 15;

/// A program's name as the list of processes shows it.
#[must_use]
pub fn listed_name(name: &str) -> Cow<'_, str> {
    Cow::Borrowed(&name[..name.floor_char_boundary(MAX_NAME_BYTES)])
}

/// Names of the running processes; empty without `/proc`.
#[must_use]
pub fn running_names() -> BTreeSet<String> {
    let Ok(entries) = fs::read_dir("/proc") else {
        return BTreeSet::new();
    };
    entries
        .filter_map(|entry| fs::read_to_string(entry.ok()?.path().join("comm")).ok())
        .map(|name| name.trim_end().to_owned())
        .collect()
}

/// This program, even if its file was replaced after the start.
#[must_use]
pub fn own_binary() -> PathBuf {
    "/proc/self/exe".into()
}

/// Whether a process runs; one that has ended and that nobody has waited for does not.
pub(in crate::platform) fn is_running(process: i32) -> bool {
    let exists = Pid::from_raw(process).is_some_and(|pid| test_kill_process(pid).is_ok());
    // The state follows the name in parentheses, which may hold any characters.
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    let state = stat.rsplit_once(") ").map_or("", |(_, rest)| rest);
    exists && !state.starts_with(['Z', 'X'])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_are_cut_as_linux_cuts_them() {
        assert_eq!(listed_name("supertux2-with-a-long-name"), "supertux2-with-");
        assert_eq!(listed_name("fceux"), "fceux");
    }
}
