//! What the writer of output files needs of the system.
#![allow(unsafe_code, reason = "no safe interface identifies a file")]

use std::fs::File;
use std::io::{self, ErrorKind};
use std::os::windows::io::AsRawHandle as _;
use std::path::Path;
use std::time::Duration;

use windows_sys::Win32::Storage::FileSystem::{
    BY_HANDLE_FILE_INFORMATION, GetFileInformationByHandle,
};

/// Attempts to rename over a file that another program has open, and the pause between two. Virus scanners and the search index
/// open new files for some 100 ms.
const RENAME_ATTEMPTS: u32 = 40;
const RENAME_PAUSE: Duration = Duration::from_millis(50);

/// Whether an open file lies at a path.
#[must_use]
pub fn is_at(file: &File, path: &Path) -> bool {
    let there = File::open(path).and_then(|there| identity(&there)).ok();
    there.is_some() && there == identity(file).ok()
}

/// Volume and number of a file.
fn identity(file: &File) -> io::Result<[u32; 3]> {
    // SAFETY: the structure holds numbers only, for which zero is valid.
    let mut found: BY_HANDLE_FILE_INFORMATION = unsafe { std::mem::zeroed() };
    // SAFETY: the handle is open as long as `file` lives, and the structure outlives the call.
    match unsafe { GetFileInformationByHandle(file.as_raw_handle(), &raw mut found) } {
        0 => Err(io::Error::last_os_error()),
        _ => Ok([
            found.dwVolumeSerialNumber,
            found.nFileIndexHigh,
            found.nFileIndexLow,
        ]),
    }
}

/// Files of a user's folder are that user's already.
///
/// # Errors
/// None.
pub fn make_private(_: &File) -> io::Result<()> {
    Ok(())
}

/// Moves a file over another, in one step where the system can (Windows 10 and later); waits for up to two seconds while another program has it open.
///
/// # Errors
/// The folder cannot be written, or the other program keeps the file open.
pub fn rename(from: &Path, to: &Path) -> io::Result<()> {
    for _ in 0..RENAME_ATTEMPTS {
        match std::fs::rename(from, to) {
            Err(error) if error.kind() == ErrorKind::PermissionDenied && !to.is_dir() => {
                if displace(from, to).is_ok() {
                    return Ok(());
                }
                std::thread::sleep(RENAME_PAUSE);
            }
            done => return done,
        }
    }
    std::fs::rename(from, to).map_err(|error| {
        io::Error::new(
            error.kind(),
            format!("{error}: another program has it open"),
        )
    })
}

/// Moves an open file out of the way first, for systems that replace none. If the new one cannot take its place, it comes back.
fn displace(from: &Path, to: &Path) -> io::Result<()> {
    let mut old = to.as_os_str().to_owned();
    old.push(format!(".{}.old", std::process::id()));
    std::fs::rename(to, &old)?;
    let done = std::fs::rename(from, to);
    match &done {
        // Its reader keeps it until it closes it.
        Ok(()) => drop(std::fs::remove_file(&old)),
        Err(_) => std::fs::rename(&old, to)?,
    }
    done
}
