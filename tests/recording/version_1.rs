//! A recording of format version 1 still replays; tests/data/recordings/README.md describes how it was made.

use std::fs;
use std::path::Path;

use anyhow::{Result, ensure};

use crate::{gelpad_ends, said};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/recordings");

pub fn replays() -> Result<()> {
    let folder = Path::new(FOLDER);
    let itself = ["replay", "version-1.mcap", "--expect", "version-1.mcap"];
    let output = gelpad_ends(folder, &itself, 0)?;
    ensure!(said(&output).contains("bit for bit"), "{}", said(&output));
    let expected = ["replay", "version-1.mcap", "--expect", "version-1.events"];
    gelpad_ends(folder, &expected, 0)?;
    let events = fs::read_to_string(folder.join("version-1.events"))?;
    for what in [
        "press key:space",
        "press key:left",
        "press key:x",
        "axis pad:left-x",
    ] {
        ensure!(events.contains(what), "the session has `{what}`");
    }
    Ok(())
}
