//! Response tables on disk: solving one takes seconds, so it is done once per pad.
//!
//! The file name is a hash of the pad's key, and the file contains the key: for a changed pad, a changed solver or a
//! damaged file, the table is solved again.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crc::{CRC_64_XZ, Crc};
use rayon::prelude::*;

use crate::eit::response::ResponseRow;
use crate::eit::{ResponseBuilder, ResponseTable, SetupError};
use crate::pad::Pad;
use crate::touch::SensingBuilder;
use crate::types::Method;

/// The environment variable that overrides the folder of the tables.
pub const FOLDER_VARIABLE: &str = "GELPAD_CACHE";

/// The folder of the tables: [`FOLDER_VARIABLE`], or else the user's cache folder; `None` if there is neither.
#[must_use]
pub fn folder() -> Option<PathBuf> {
    match std::env::var_os(FOLDER_VARIABLE) {
        Some(folder) => Some(folder.into()),
        None => directories::ProjectDirs::from("", "", "gelpad")
            .map(|folders| folders.cache_dir().to_owned()),
    }
}

/// Loads a pad's table from a folder; `None` if there is no valid one.
#[must_use]
pub fn load(pad: &Pad, folder: &Path) -> Option<ResponseTable> {
    let key = ResponseBuilder::key(pad);
    let bytes = fs::read(folder.join(file_name(&key))).ok()?;
    match ResponseTable::from_bytes(&bytes, pad) {
        Ok(table) if table.key() == key => Some(table),
        Ok(_) => None,
        Err(error) => {
            tracing::warn!("{}: {error}; it will be solved again", folder.display());
            None
        }
    }
}

/// Receives the number of finished rows of a table, and of all rows.
pub type RowProgress<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// Solves a pad's table on all cores; that of a pad with deviations from the table of its drawing.
///
/// # Errors
/// A pad that cannot be solved.
pub fn solve(pad: &Pad, progress: RowProgress<'_>) -> Result<ResponseTable, SetupError> {
    let builder = if pad.deviations.is_none() {
        ResponseBuilder::new(pad)?
    } else {
        let drawing = load_or_solve(&pad.drawing(), progress)?;
        ResponseBuilder::from_drawing(pad, Arc::new(drawing))?
    };
    let count = builder.rows();
    let done = AtomicUsize::new(0);
    let rows: Vec<ResponseRow> = (0..count)
        .into_par_iter()
        .with_max_len(1)
        .map(|index| {
            let row = builder.solve_row(index);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, count);
            row
        })
        .collect();
    Ok(builder.finish(&rows))
}

/// Stores a table where [`load`] finds it.
///
/// # Errors
/// A folder or file that cannot be written.
pub fn store(table: &ResponseTable, folder: &Path) -> std::io::Result<()> {
    fs::create_dir_all(folder)?;
    // Renamed when complete, so that no reader finds a partial table.
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(&table.to_bytes())?;
    file.persist(folder.join(file_name(table.key())))?;
    Ok(())
}

/// Removes a pad's table, if it is there.
pub fn remove(pad: &Pad, folder: &Path) {
    // Only disk space is lost where that fails.
    let _ = fs::remove_file(folder.join(file_name(&ResponseBuilder::key(pad))));
}

/// A pad's sensing builder. The matrix is prepared while the table is loaded or solved.
///
/// # Errors
/// A pad that cannot be solved.
pub fn sensing_builder(
    pad: &Pad,
    method: Method,
    progress: impl Fn(usize, usize) + Send + Sync,
) -> Result<SensingBuilder, SetupError> {
    let (table, builder) = rayon::join(
        || load_or_solve(pad, &progress),
        || SensingBuilder::new(pad, method),
    );
    Ok(builder?.with_table(Arc::new(table?)))
}

/// A pad's table: loaded from the cache, or solved and stored there.
///
/// # Errors
/// A pad that cannot be solved. A cache that cannot be written only logs a warning.
pub fn load_or_solve(pad: &Pad, progress: RowProgress<'_>) -> Result<ResponseTable, SetupError> {
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
