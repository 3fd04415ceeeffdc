//! Whether the writer of a file with held outputs lives: it has locked the file.

use std::fs::File;
use std::io;
use std::path::Path;

/// Marks a file as that of this process, until that ends.
pub(in crate::platform) fn claim(file: &File) -> io::Result<()> {
    file.try_lock().map_err(Into::into)
}

/// Whether the process that claimed a file lives; none if the file is gone.
pub(in crate::platform) fn is_claimed(path: &Path) -> Option<bool> {
    Some(File::open(path).ok()?.try_lock_shared().is_err())
}
