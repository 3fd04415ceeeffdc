//! Whether the writer of a file with held outputs lives. A lock would keep others from reading the file here, so the number of the
//! process, which is the file's name, tells it.

use std::fs::File;
use std::io;
use std::path::Path;

use crate::platform::windows::processes::is_running;

/// Nothing marks a file but its name.
pub(in crate::platform) fn claim(_: &File) -> io::Result<()> {
    Ok(())
}

/// Whether the process that wrote a file lives; none if the name is not a number.
pub(in crate::platform) fn is_claimed(path: &Path) -> Option<bool> {
    let process = path.file_stem()?.to_str()?.parse().ok()?;
    Some(is_running(process))
}
