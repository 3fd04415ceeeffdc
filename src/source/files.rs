//! Frames from a file, whatever it holds: what it is shows in its first bytes, not in its name.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::{EitFolder, FramesCsv, FramesTable, RecordedFrames, Source, SourceError};
use crate::pad::Pad;

/// Bytes that tell what a file is.
const TELLING_BYTES: u64 = 4096;
/// How a recording begins.
const RECORDING: &[u8] = b"\x89MCAP0\r\n";

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A gelpad recording (`.mcap`).
    Recording,
    /// Frames as CSV with a header: `t_ms,v0,v1,...`.
    Csv,
    /// A folder of Sciospec's `.eit` files, or one of them.
    Eit,
    /// A table of numbers, frames as columns.
    Table,
}

/// Tells what a file or folder holds.
///
/// # Errors
/// What cannot be read.
pub fn file_kind(path: &Path) -> Result<FileKind, SourceError> {
    let failed = |error| SourceError::File {
        path: path.to_owned(),
        error,
    };
    if path.is_dir() || path.extension().is_some_and(|extension| extension == "eit") {
        return Ok(FileKind::Eit);
    }
    let mut start = Vec::new();
    File::open(path)
        .and_then(|file| file.take(TELLING_BYTES).read_to_end(&mut start))
        .map_err(failed)?;
    if start.starts_with(RECORDING) {
        return Ok(FileKind::Recording);
    }
    let text = String::from_utf8_lossy(&start);
    let first_line = text
        .lines()
        .find(|line| !line.trim().is_empty() && !line.starts_with(['#', '%']));
    let is_number = |word: &str| word.trim().parse::<f64>().is_ok();
    let looks_like_table = first_line.is_some_and(|line| {
        line.split([',', ';', '\t', ' '])
            .filter(|word| !word.trim().is_empty())
            .all(is_number)
    });
    // What is neither is told by the reader of CSV, whose message names what it expects.
    Ok(if looks_like_table {
        FileKind::Table
    } else {
        FileKind::Csv
    })
}

/// Opens a file of a pad's frames.
///
/// # Errors
/// A file that cannot be read, or holds something else or another pad's frames.
pub fn open_file(path: &Path, pad: &Pad) -> Result<Box<dyn Source>, SourceError> {
    Ok(match file_kind(path)? {
        FileKind::Csv => Box::new(FramesCsv::open(path, pad.channels())?),
        FileKind::Eit => Box::new(EitFolder::open(path, pad)?),
        FileKind::Table => Box::new(FramesTable::open(path, pad)?),
        FileKind::Recording => Box::new(RecordedFrames::open(path, pad.channels())?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_file_is_told_by_what_it_holds() {
        let kind = |bytes: &[u8]| {
            let mut file = tempfile::NamedTempFile::new().expect("a file");
            file.write_all(bytes).expect("written");
            file_kind(file.path()).expect("readable")
        };
        assert_eq!(kind(b"t_ms,v0,v1\n0,1,2\n"), FileKind::Csv);
        assert_eq!(kind(b""), FileKind::Csv);
        assert_eq!(kind(b"% made by EIDORS\n 1.0e-1  2.0 \n"), FileKind::Table);
        assert_eq!(kind(b"0.1,-0.2,0.1,-0.3\n"), FileKind::Table);
        assert_eq!(kind(b"\x89MCAP0\r\n\x01"), FileKind::Recording);
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(file_kind(folder.path()).expect("readable"), FileKind::Eit);
    }
}
