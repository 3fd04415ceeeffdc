//! Frames from a file of any supported kind, recognised by its first bytes and not by its name.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::{EitFolder, FramesCsv, FramesTable, RecordedFrames, Source, SourceError};
use crate::pad::Pad;

/// Number of bytes that are read to recognise a file.
const START_BYTES: u64 = 4096;
/// What stands between the numbers of a table.
const SEPARATORS: [char; 4] = [',', ';', '\t', ' '];
/// First bytes of a recording.
const RECORDING_MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Kind of a file of frames.
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

/// Recognises what a file or folder holds.
///
/// # Errors
/// The file cannot be read.
pub fn file_kind(path: &Path) -> Result<FileKind, SourceError> {
    let failed = |error| SourceError::file(path, error);
    if path.is_dir() || path.extension().is_some_and(|extension| extension == "eit") {
        return Ok(FileKind::Eit);
    }
    let mut start = Vec::new();
    File::open(path)
        .and_then(|file| file.take(START_BYTES).read_to_end(&mut start))
        .map_err(failed)?;
    if start.starts_with(RECORDING_MAGIC) {
        return Ok(FileKind::Recording);
    }
    // The last number of a long line may be cut.
    if start.len() as u64 == START_BYTES {
        let is_separator = |byte: &u8| SEPARATORS.contains(&char::from(*byte)) || *byte == b'\n';
        let whole = start.iter().rposition(is_separator).unwrap_or_default();
        start.truncate(whole);
    }
    let text = String::from_utf8_lossy(&start);
    let first_line = text
        .lines()
        .find(|line| !line.trim().is_empty() && !line.starts_with(['#', '%']));
    let is_number = |word: &str| word.trim().parse::<f64>().is_ok();
    let looks_like_table = first_line.is_some_and(|line| {
        line.split(SEPARATORS)
            .filter(|word| !word.trim().is_empty())
            .all(is_number)
    });
    // Anything else goes to the CSV reader, whose error says what it expects.
    Ok(if looks_like_table {
        FileKind::Table
    } else {
        FileKind::Csv
    })
}

/// Opens a file of frames of a pad.
///
/// # Errors
/// The file cannot be read, or does not hold frames of this pad.
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
    fn a_file_is_recognised_by_its_content() {
        let kind = |bytes: &[u8]| {
            let mut file = tempfile::NamedTempFile::new().expect("a file");
            file.write_all(bytes).expect("written");
            file_kind(file.path()).expect("readable")
        };
        assert_eq!(kind(b"t_ms,v0,v1\n0,1,2\n"), FileKind::Csv);
        assert_eq!(kind(b""), FileKind::Csv);
        assert_eq!(kind(b"% made by EIDORS\n 1.0e-1  2.0 \n"), FileKind::Table);
        assert_eq!(kind(b"0.1,-0.2,0.1,-0.3\n"), FileKind::Table);
        let row = format!("0.10000,{}", "-1.2345e-02,".repeat(400)).into_bytes();
        assert!(row[..4096].ends_with(b"e"));
        assert_eq!(kind(&row), FileKind::Table, "the last number is cut");
        assert_eq!(kind(b"\x89MCAP0\r\n\x01"), FileKind::Recording);
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(file_kind(folder.path()).expect("readable"), FileKind::Eit);
    }
}
