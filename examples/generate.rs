//! Writes what packages contain besides the program: completions of shells, man pages and the schema of profiles.
//!
//! ```text
//! cargo run --example generate -- FOLDER
//! ```

use std::fs;
use std::path::PathBuf;

use anyhow::{Context as _, Result};
use clap_complete::Shell;

fn main() -> Result<()> {
    let folder = std::env::args_os().nth(1).context("write: generate FOLDER");
    let folder = PathBuf::from(folder?);
    let completions = folder.join("completions");
    let pages = folder.join("man");
    fs::create_dir_all(&completions)?;
    fs::create_dir_all(&pages)?;
    let mut command = gelpad::cli::command();
    for shell in [Shell::Bash, Shell::Zsh, Shell::Fish, Shell::PowerShell] {
        clap_complete::generate_to(shell, &mut command, "gelpad", &completions)?;
    }
    clap_mangen::generate_to(command, &pages)?;
    let schema = gelpad::profile::schema();
    fs::write(folder.join("profile.schema.json"), schema)?;
    Ok(())
}
