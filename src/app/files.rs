//! Files that are written completely or not at all: to `NAME.part` first, then renamed.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::AppError;

/// Writes a file.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), AppError> {
    let mut file = PartFile::create(path)?;
    file.write_all(bytes)
        .map_err(|error| write_error(path, error))?;
    file.finish()
}

/// A file that is being written; dropping it unfinished removes it.
pub(crate) struct PartFile {
    file: BufWriter<File>,
    part: PathBuf,
    path: PathBuf,
    finished: bool,
}

impl PartFile {
    /// Starts a file.
    pub(crate) fn create(path: &Path) -> Result<Self, AppError> {
        let mut part = path.as_os_str().to_owned();
        part.push(".part");
        let part = PathBuf::from(part);
        let file = File::create(&part).map_err(|error| write_error(path, error))?;
        Ok(Self {
            file: BufWriter::new(file),
            part,
            path: path.to_owned(),
            finished: false,
        })
    }

    /// Moves the file to its place.
    pub(crate) fn finish(mut self) -> Result<(), AppError> {
        self.file
            .flush()
            .and_then(|()| self.file.get_ref().sync_all())
            .and_then(|()| std::fs::rename(&self.part, &self.path))
            .map_err(|error| write_error(&self.path, error))?;
        self.finished = true;
        Ok(())
    }
}

impl Write for PartFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

impl Drop for PartFile {
    fn drop(&mut self) {
        if !self.finished {
            let _ = std::fs::remove_file(&self.part);
        }
    }
}

fn write_error(path: &Path, error: std::io::Error) -> AppError {
    AppError::Write {
        path: path.to_owned(),
        error,
    }
}
