//! What the writer of output files needs of the system.

use std::fs::{File, Metadata, Permissions};
use std::io;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::path::Path;

/// Whether an open file lies at a path.
#[must_use]
pub fn is_at(file: &File, path: &Path) -> bool {
    let id = |found: Metadata| (found.dev(), found.ino());
    let found = path.symlink_metadata().map(id);
    matches!((file.metadata().map(id), found), (Ok(one), Ok(other)) if one == other)
}

/// Nobody else may read a file that is not finished.
///
/// # Errors
/// The file system has no permissions.
pub fn make_private(file: &File) -> io::Result<()> {
    file.set_permissions(Permissions::from_mode(0o600))
}

/// Moves a file over another, in one step.
///
/// # Errors
/// The folder cannot be written.
pub fn rename(from: &Path, to: &Path) -> io::Result<()> {
    std::fs::rename(from, to)
}
