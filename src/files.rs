//! Output files that are written completely or not at all: to a private `NAME.part` first, which is then renamed.
//!
//! Only regular files are replaced. `-` and `/dev/stdout` are standard output, and whatever else is not a regular file (a
//! device, a pipe) is written to as it is.
//!
//! Invariants: a part file is created, never opened: no link at its place is followed and no other writer's part is
//! touched (each writer locks its own). It is removed if it is not finished; one that a killed writer left is removed by
//! the next.

use std::fs::{File, OpenOptions, Permissions, TryLockError};
use std::io::{self, BufWriter, ErrorKind, Seek as _, Write};
use std::path::{Path, PathBuf};

use crate::platform::files::{is_at, make_private, rename};

/// Attempts to create a part file; more are needed only if others create and remove one at the same time.
const ATTEMPTS: usize = 8;

/// A file that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be written: {error}", path.display())]
pub struct FileError {
    path: PathBuf,
    error: io::Error,
}

impl FileError {
    /// An error about a file.
    #[must_use]
    pub fn new(path: &Path, error: io::Error) -> Self {
        Self {
            path: path.to_owned(),
            error,
        }
    }

    /// Whether the reader of a pipe has closed it.
    #[must_use]
    pub fn is_closed_pipe(&self) -> bool {
        self.error.kind() == ErrorKind::BrokenPipe
    }
}

/// Where an output goes.
enum Destination {
    Stdout,
    /// A device or a pipe.
    Stream,
    /// A regular file that exists, or none.
    File(PathBuf),
}

impl Destination {
    fn from_path(path: &Path) -> io::Result<Self> {
        if is_stdout(path) {
            return Ok(Self::Stdout);
        }
        match path.metadata() {
            Ok(found) if found.is_file() => {
                // A file that may not be written is not replaced either.
                OpenOptions::new().append(true).open(path)?;
                // A link stays, its target is replaced.
                path.canonicalize().map(Self::File)
            }
            Ok(found) if found.is_dir() => Err(ErrorKind::IsADirectory.into()),
            Ok(_) => Ok(Self::Stream),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(Self::File(path.to_owned())),
            Err(error) => Err(error),
        }
    }
}

fn is_stdout(path: &Path) -> bool {
    ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"]
        .iter()
        .any(|name| path == Path::new(name))
}

/// Whether two paths name the same existing file.
#[must_use]
pub fn is_same(one: &Path, other: &Path) -> bool {
    match (one.canonicalize(), other.canonicalize()) {
        (Ok(one), Ok(other)) => one == other,
        _ => false,
    }
}

/// Refuses to write the output of a command over its input.
///
/// # Errors
/// Both are the same file.
pub fn refuse_input(input: &Path, output: &Path) -> Result<(), FileError> {
    if !is_stdout(output) && is_same(input, output) && input.is_file() {
        let reason = "it is the file that is read\n  help: write to another file";
        return Err(FileError::new(output, io::Error::other(reason)));
    }
    Ok(())
}

/// Writes a file.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let mut file = OutputFile::create(path)?;
    file.write_all(bytes)
        .map_err(|error| FileError::new(path, error))?;
    file.finish()
}

/// An output that is written from beginning to end.
pub struct OutputFile {
    path: PathBuf,
    writer: BufWriter<Box<dyn Write>>,
    part: Option<PartFile>,
}

impl OutputFile {
    /// Starts an output.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn create(path: &Path) -> Result<Self, FileError> {
        Self::open(path).map_err(|error| FileError::new(path, error))
    }

    fn open(path: &Path) -> io::Result<Self> {
        let mut part = None;
        let writer: Box<dyn Write> = match Destination::from_path(path)? {
            Destination::Stdout => Box::new(io::stdout()),
            Destination::Stream => Box::new(OpenOptions::new().write(true).open(path)?),
            Destination::File(path) => {
                let created = PartFile::open(&path)?;
                let file = created.file.try_clone()?;
                part = Some(created);
                Box::new(file)
            }
        };
        Ok(Self {
            path: path.to_owned(),
            writer: BufWriter::new(writer),
            part,
        })
    }

    /// Completes the output.
    ///
    /// # Errors
    /// It cannot be written; a file that was there before stays.
    pub fn finish(mut self) -> Result<(), FileError> {
        let flushed = self.writer.flush();
        flushed.map_err(|error| FileError::new(&self.path, error))?;
        self.part.map_or(Ok(()), PartFile::finish)
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// Writes an output that needs to seek; what is not a regular file gets a copy of the finished bytes.
///
/// # Errors
/// The output cannot be written, or `write` fails.
pub fn write_seekable<T, E: From<FileError>>(
    path: &Path,
    write: impl FnOnce(File) -> Result<T, E>,
) -> Result<T, E> {
    let failed = |error| FileError::new(path, error);
    if let Destination::File(path) = Destination::from_path(path).map_err(failed)? {
        let part = PartFile::open(&path).map_err(failed)?;
        let written = write(part.file.try_clone().map_err(failed)?)?;
        part.finish()?;
        return Ok(written);
    }
    let mut whole = tempfile::tempfile().map_err(failed)?;
    let written = write(whole.try_clone().map_err(failed)?)?;
    let mut out = OutputFile::create(path)?;
    whole.rewind().map_err(failed)?;
    io::copy(&mut whole, &mut out).map_err(failed)?;
    out.finish()?;
    Ok(written)
}

/// A part file; dropping it unfinished removes it.
struct PartFile {
    file: File,
    part: PathBuf,
    path: PathBuf,
    /// Permissions of the finished file.
    permissions: Permissions,
    is_finished: bool,
}

impl PartFile {
    fn open(path: &Path) -> io::Result<Self> {
        let mut part = path.as_os_str().to_owned();
        part.push(".part");
        let part = PathBuf::from(part);
        let file = create_locked(&part)?;
        let own = file.metadata()?.permissions();
        make_private(&file)?;
        Ok(Self {
            file,
            permissions: path.metadata().map_or(own, |old| old.permissions()),
            part,
            path: path.to_owned(),
            is_finished: false,
        })
    }

    fn finish(self) -> Result<(), FileError> {
        let path = self.path.clone();
        self.complete()
            .map_err(|error| FileError::new(&path, error))
    }

    /// Moves the file to its place.
    fn complete(mut self) -> io::Result<()> {
        self.file.set_permissions(self.permissions.clone())?;
        self.file.sync_all()?;
        rename(&self.part, &self.path)?;
        self.is_finished = true;
        Ok(())
    }
}

impl Drop for PartFile {
    fn drop(&mut self) {
        if !self.is_finished {
            let _ = std::fs::remove_file(&self.part);
        }
    }
}

/// Creates a file and locks it; one that nobody has locked is the remains of a killed writer and is removed.
fn create_locked(path: &Path) -> io::Result<File> {
    for _ in 0..ATTEMPTS {
        match File::create_new(path) {
            Ok(file) => {
                lock(&file)?;
                // Another writer may have taken the new file for remains before it was locked.
                if is_at(&file, path) {
                    return Ok(file);
                }
            }
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                if path.symlink_metadata()?.is_file() {
                    lock(&File::open(path)?)?;
                }
                std::fs::remove_file(path)?;
            }
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::other(
        "other programs keep creating its part file",
    ))
}

/// Locks a file that is being written, until it is closed.
///
/// # Errors
/// Another gelpad has locked it.
pub fn lock(file: &File) -> io::Result<()> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(io::Error::new(
            ErrorKind::ResourceBusy,
            "another gelpad is writing it",
        )),
        // Some network folders have no locks.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[cfg(unix)]
    use std::os::unix::fs::{PermissionsExt as _, symlink};

    #[cfg(unix)]
    #[test]
    fn a_part_file_follows_no_link_and_is_private() {
        let folder = tempfile::tempdir().expect("a folder");
        let (path, part) = (folder.path().join("x"), folder.path().join("x.part"));
        let victim = folder.path().join("victim");
        std::fs::write(&victim, "precious").expect("written");
        symlink(&victim, &part).expect("a link");
        let mut file = OutputFile::create(&path).expect("created");
        let mode = part.symlink_metadata().expect("there").permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
        file.write_all(b"new").expect("written");
        file.finish().expect("finished");
        assert_eq!(std::fs::read_to_string(&victim).expect("text"), "precious");
        assert_eq!(std::fs::read_to_string(&path).expect("text"), "new");
        assert!(!part.exists());
        let mode = path.metadata().expect("there").permissions().mode();
        assert_ne!(mode & 0o400, 0);
    }

    #[test]
    fn remains_are_removed_but_not_the_part_of_a_running_writer() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("x");
        std::fs::write(folder.path().join("x.part"), "remains").expect("written");
        let first = OutputFile::create(&path).expect("created");
        let second = OutputFile::create(&path).err().expect("refused");
        assert!(second.to_string().contains("another gelpad"), "{second}");
        drop(first);
        assert_eq!(std::fs::read_dir(folder.path()).expect("read").count(), 0);
    }

    #[cfg(unix)]
    #[test]
    fn a_replaced_file_keeps_its_permissions_and_a_link_its_place() {
        let folder = tempfile::tempdir().expect("a folder");
        let (path, link) = (folder.path().join("x"), folder.path().join("link"));
        std::fs::write(&path, "old").expect("written");
        let permissions = Permissions::from_mode(0o640);
        std::fs::set_permissions(&path, permissions).expect("set");
        symlink(&path, &link).expect("a link");
        write(&link, b"new").expect("written");
        assert!(link.symlink_metadata().expect("there").is_symlink());
        assert_eq!(std::fs::read_to_string(&path).expect("text"), "new");
        let mode = path.metadata().expect("there").permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
    }
}
