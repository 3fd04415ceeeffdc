//! A pad's table of responses: from the disk, or solved and put there.
//!
//! Solving takes seconds, so it is done once a pad. A file's name is a hash of the pad's key, and the key stands in the file: a
//! changed pad, a changed solver or a damaged file is solved anew.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crc::{CRC_64_XZ, Crc};

use crate::eit::response::ResponseRow;
use crate::eit::{ResponseBuilder, ResponseTable, SetupError};
use crate::pad::Pad;
use crate::touch::SensingBuilder;
use crate::types::Method;

/// Where tables are kept if this variable does not say: the user's cache folder.
pub const FOLDER_VARIABLE: &str = "GELPAD_CACHE";

/// The folder that keeps tables, if there is one.
#[must_use]
pub fn folder() -> Option<PathBuf> {
    match std::env::var_os(FOLDER_VARIABLE) {
        Some(folder) => Some(folder.into()),
        None => directories::ProjectDirs::from("", "", "gelpad")
            .map(|folders| folders.cache_dir().to_owned()),
    }
}

/// A pad's table from a folder, if it is there and sound.
#[must_use]
pub fn load(pad: &Pad, folder: &Path) -> Option<ResponseTable> {
    let key = ResponseBuilder::key(pad);
    let bytes = fs::read(folder.join(file_name(&key))).ok()?;
    match ResponseTable::from_bytes(&bytes) {
        Ok(table) if table.key() == key => Some(table),
        Ok(_) => None,
        Err(error) => {
            tracing::warn!("{}: {error}: solved anew", folder.display());
            None
        }
    }
}

/// Solves a pad's table on all cores; `progress` is told how many rows of how many are done.
///
/// # Errors
/// A pad that cannot be solved.
pub fn solve(
    pad: &Pad,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<ResponseTable, SetupError> {
    let builder = ResponseBuilder::new(pad)?;
    let rows = builder.rows();
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || {
        let mut solved = Vec::new();
        loop {
            let row = next.fetch_add(1, Ordering::Relaxed);
            if row >= rows {
                return solved;
            }
            solved.push((row, builder.solve_row(row)));
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, rows);
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut solved: Vec<(usize, ResponseRow)> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        threads
            .into_iter()
            .flat_map(|thread| match thread.join() {
                Ok(rows) => rows,
                Err(panic) => std::panic::resume_unwind(panic),
            })
            .collect()
    });
    solved.sort_by_key(|(row, _)| *row);
    let rows: Vec<ResponseRow> = solved.into_iter().map(|(_, row)| row).collect();
    Ok(builder.finish(&rows))
}

/// Puts a table where [`load`] finds it.
///
/// # Errors
/// A folder or file that cannot be written.
pub fn store(table: &ResponseTable, folder: &Path) -> std::io::Result<()> {
    fs::create_dir_all(folder)?;
    // Written beside and renamed: nobody reads half a table.
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(&table.to_bytes())?;
    file.persist(folder.join(file_name(table.key())))?;
    Ok(())
}

/// What reads a pad's frames: its matrix, made while its table is read from the cache or solved.
///
/// # Errors
/// A pad that cannot be solved.
pub fn sensing(
    pad: &Pad,
    method: Method,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<SensingBuilder, SetupError> {
    let (table, builder) = std::thread::scope(|scope| {
        let table = scope.spawn(|| table(pad, &progress));
        let builder = SensingBuilder::new(pad, method);
        (table.join(), builder)
    });
    let table = table.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
    Ok(builder?.with_table(Arc::new(table)))
}

/// A pad's table: from the cache, or solved and put there.
///
/// # Errors
/// A pad that cannot be solved. A cache that cannot be written is told and no error.
pub fn table(
    pad: &Pad,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<ResponseTable, SetupError> {
    let folder = folder();
    if let Some(table) = folder.as_deref().and_then(|folder| load(pad, folder)) {
        return Ok(table);
    }
    let table = solve(pad, progress)?;
    if let Some(folder) = folder
        && let Err(error) = store(&table, &folder)
    {
        tracing::warn!(
            "{}: {error}: the pad will be solved again at the next start",
            folder.display()
        );
    }
    Ok(table)
}

fn file_name(key: &str) -> String {
    const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);
    format!("responses-{:016x}.bin", CRC.checksum(key.as_bytes()))
}
