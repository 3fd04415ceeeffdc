//! Processes of this computer.
#![allow(unsafe_code, reason = "no safe interface lists processes")]

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::os::windows::io::{FromRawHandle as _, OwnedHandle};
use std::path::PathBuf;

pub use super::rights::{Rights, foreground_rights, own_rights};

use windows_sys::Win32::Foundation::{INVALID_HANDLE_VALUE, WAIT_TIMEOUT};
use windows_sys::Win32::System::Diagnostics::ToolHelp::{
    CreateToolhelp32Snapshot, PROCESSENTRY32W, Process32FirstW, Process32NextW, TH32CS_SNAPPROCESS,
};
use windows_sys::Win32::System::Threading::{
    OpenProcess, PROCESS_SYNCHRONIZE, WaitForSingleObject,
};

/// The end of programs' names, which profiles leave out.
const ENDING: &str = ".exe";

/// A program's name as the list of processes shows it: in small letters, without `.exe`.
#[must_use]
pub fn listed_name(name: &str) -> Cow<'_, str> {
    let name = name.to_lowercase();
    Cow::Owned(name.strip_suffix(ENDING).unwrap_or(&name).to_owned())
}

/// Names of the running processes; empty if they cannot be listed.
#[must_use]
pub fn running_names() -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    // SAFETY: the call takes numbers and returns a handle.
    let snapshot = unsafe { CreateToolhelp32Snapshot(TH32CS_SNAPPROCESS, 0) };
    if snapshot == INVALID_HANDLE_VALUE {
        return names;
    }
    // SAFETY: nobody else has the handle.
    let _closed_at_the_end = unsafe { OwnedHandle::from_raw_handle(snapshot) };
    // SAFETY: the structure holds numbers only, for which zero is valid.
    let mut entry: PROCESSENTRY32W = unsafe { std::mem::zeroed() };
    entry.dwSize = size_of::<PROCESSENTRY32W>() as u32;
    // SAFETY: the structure has its size in `dwSize` and outlives the calls.
    let mut is_there = unsafe { Process32FirstW(snapshot, &raw mut entry) } != 0;
    while is_there {
        let end = entry.szExeFile.iter().position(|unit| *unit == 0);
        let name = String::from_utf16_lossy(&entry.szExeFile[..end.unwrap_or(0)]);
        names.insert(listed_name(&name).into_owned());
        // SAFETY: as above.
        is_there = unsafe { Process32NextW(snapshot, &raw mut entry) } != 0;
    }
    names
}

/// This program.
#[must_use]
pub fn own_binary() -> PathBuf {
    std::env::current_exe().unwrap_or_else(|_| "gelpad.exe".into())
}

/// A handle of a process that can be waited for.
pub(super) fn open(process: u32) -> Option<OwnedHandle> {
    // SAFETY: the call takes numbers and returns a handle, or null.
    let handle = unsafe { OpenProcess(PROCESS_SYNCHRONIZE, 0, process) };
    // SAFETY: nobody else has the handle.
    (!handle.is_null()).then(|| unsafe { OwnedHandle::from_raw_handle(handle) })
}

/// Waits until a process has ended, at most for a time; whether it has.
pub(super) fn wait(process: &OwnedHandle, limit_ms: u32) -> bool {
    use std::os::windows::io::AsRawHandle as _;
    // SAFETY: the handle is open as long as `process` lives.
    unsafe { WaitForSingleObject(process.as_raw_handle(), limit_ms) != WAIT_TIMEOUT }
}

/// Whether a process runs.
pub(in crate::platform) fn is_running(process: i32) -> bool {
    u32::try_from(process)
        .ok()
        .and_then(open)
        .is_some_and(|process| !wait(&process, 0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_process_is_listed_and_runs() {
        let own = own_binary();
        let own = own.file_name().expect("a name").to_string_lossy();
        assert!(running_names().contains(&*listed_name(&own)));
        assert!(is_running(std::process::id() as i32));
        assert!(!is_running(i32::MAX - 3));
    }
}
