//! Response tables and linearised pads on disk: solving a table takes seconds, and a linearised pad half of the time of a
//! start, so it is done once per pad.
//!
//! The file name is a hash of the pad's key, and the file contains the key: for a changed pad, a changed solver or a
//! damaged file, it is solved again.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crc::{CRC_64_XZ, Crc};
use rayon::prelude::*;

use crate::eit::response::ResponseRow;
use crate::eit::{Linearised, ResponseBuilder, ResponseTable, SetupError};
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
    write(folder, &file_name(table.key()), &table.to_bytes())
}

/// Removes what is stored of a pad, if it is there.
pub fn remove(pad: &Pad, folder: &Path) {
    for name in [
        file_name(&ResponseBuilder::key(pad)),
        linearised_name(&Linearised::key(pad)),
    ] {
        // Only disk space is lost where that fails.
        let _ = fs::remove_file(folder.join(name));
    }
}

/// A pad's sensing builder. The linearised pad is prepared while the table is loaded or solved.
///
/// # Errors
/// A pad that cannot be solved.
pub fn sensing_builder(
    pad: &Pad,
    method: Method,
    progress: impl Fn(usize, usize) + Send + Sync,
) -> Result<SensingBuilder, SetupError> {
    let (table, linearised) = rayon::join(
        || load_or_solve(pad, &progress),
        || linearised(pad, folder().as_deref()),
    );
    Ok(SensingBuilder::from_linearised(linearised?, pad, method).with_table(Arc::new(table?)))
}

/// The linearised pad: loaded from the cache, or solved and stored there.
fn linearised(pad: &Pad, folder: Option<&Path>) -> Result<Linearised, SetupError> {
    let Some(folder) = folder else {
        return Linearised::from_pad(pad);
    };
    let key = Linearised::key(pad);
    let name = linearised_name(&key);
    let stored = fs::read(folder.join(&name)).ok();
    if let Some(stored) = stored.and_then(|bytes| Linearised::from_bytes(&bytes, pad, &key)) {
        return Ok(stored);
    }
    let linearised = Linearised::from_pad(pad)?;
    // It takes milliseconds to solve again, and where the folder is at fault, the table's warning says so.
    let _ = write(folder, &name, &linearised.to_bytes(&key));
    Ok(linearised)
}

/// Writes a file that no reader finds before it is complete.
fn write(folder: &Path, name: &str, bytes: &[u8]) -> std::io::Result<()> {
    fs::create_dir_all(folder)?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(bytes)?;
    file.persist(folder.join(name))?;
    Ok(())
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
    format!("responses-{:016x}.bin", hash(key))
}

fn linearised_name(key: &str) -> String {
    format!("linearised-{:016x}.bin", hash(key))
}

fn hash(key: &str) -> u64 {
    const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);
    CRC.checksum(key.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::shipped_pad;

    fn round_tank() -> Pad {
        let text = shipped_pad("round-tank").expect("shipped").toml;
        Pad::from_toml("round-tank", text).expect("sound")
    }

    #[test]
    fn a_linearised_pad_is_stored_once_and_solved_again_where_its_file_is_damaged() {
        let (pad, folder) = (round_tank(), tempfile::tempdir().expect("writable"));
        let path = folder.path().join(linearised_name(&Linearised::key(&pad)));
        let read = || {
            linearised(&pad, Some(folder.path()))
                .expect("solvable")
                .jacobian
        };
        let solved = read();
        let whole = fs::read(&path).expect("stored");
        assert_eq!(read(), solved);
        fs::write(&path, &whole[..whole.len() / 2]).expect("writable");
        assert_eq!(read(), solved);
        assert_eq!(fs::read(&path).expect("stored again"), whole);
        remove(&pad, folder.path());
        assert!(!path.exists());
    }

    #[test]
    fn a_cache_that_cannot_be_written_stops_nothing() {
        let file = tempfile::NamedTempFile::new().expect("writable");
        let linearised = linearised(&round_tank(), Some(file.path())).expect("solvable");
        assert!(!linearised.active.is_empty());
    }
}
