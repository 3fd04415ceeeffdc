//! The external programs that the game test runs.

use std::env;
use std::path::PathBuf;

use anyhow::{Result, bail};

/// Paths of the programs; the test needs all of them.
#[derive(Clone, Debug)]
pub struct Tools {
    pub ca65: PathBuf,
    pub ld65: PathBuf,
    pub xvfb: PathBuf,
    pub xdotool: PathBuf,
    pub fceux: PathBuf,
}

impl Tools {
    /// The error names all missing programs.
    pub fn find() -> Result<Self> {
        let mut missing = Vec::new();
        let mut find = |name: &'static str| {
            program(name).unwrap_or_else(|| {
                missing.push(name);
                PathBuf::new()
            })
        };
        let tools = Self {
            ca65: find("ca65"),
            ld65: find("ld65"),
            xvfb: find("Xvfb"),
            xdotool: find("xdotool"),
            fceux: find("fceux"),
        };
        find("bash"); // log.lua runs it
        if !missing.is_empty() {
            bail!("not installed: {}", missing.join(", "));
        }
        Ok(tools)
    }
}

/// Whether a missing program is a failure, as on the machine that must run everything.
pub fn all_required() -> bool {
    env::var_os("GELPAD_TEST_ALL").is_some_and(|value| value == "1")
}

/// Searches PATH and Debian's folder of games, which root's PATH lacks.
pub fn program(name: &str) -> Option<PathBuf> {
    let path = env::var_os("PATH").unwrap_or_default();
    env::split_paths(&path)
        .chain([PathBuf::from("/usr/games")])
        .map(|folder| folder.join(name))
        .find(|file| file.is_file())
}
