//! Files that are read more than once, from standard input and pipes too.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use tempfile::TempDir;

/// Replaces `-` and pipes by a temporary copy of what they send: a file is recognised by its first bytes and then read from
/// its beginning. The copy is removed when the result is dropped.
pub(super) fn copy_pipe(file: &mut PathBuf) -> anyhow::Result<Option<TempDir>> {
    let is_stdin = file.as_path() == Path::new("-");
    let is_stream = file
        .metadata()
        .is_ok_and(|found| !found.is_file() && !found.is_dir());
    if !is_stdin && !is_stream {
        return Ok(None);
    }
    let shown = file.display().to_string();
    copy(file, is_stdin).with_context(|| shown).map(Some)
}

fn copy(file: &mut PathBuf, is_stdin: bool) -> io::Result<TempDir> {
    let mut input: Box<dyn Read> = match is_stdin {
        true => Box::new(io::stdin().lock()),
        false => Box::new(File::open(&*file)?),
    };
    let folder = tempfile::tempdir()?;
    // Messages name the copy.
    let name = match is_stdin {
        true => "stdin".into(),
        false => file.file_name().unwrap_or("pipe".as_ref()).to_owned(),
    };
    let path = folder.path().join(name);
    io::copy(&mut input, &mut File::create_new(&path)?)?;
    *file = path;
    Ok(folder)
}
