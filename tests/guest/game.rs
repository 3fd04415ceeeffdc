//! fceux plays the game of `tests/game` by gelpad's pad.

use anyhow::{Result, bail};

pub fn needs() -> Result<(), String> {
    Err("to do".to_owned())
}

pub fn play() -> Result<()> {
    bail!("to do")
}

pub fn inside() -> Result<()> {
    bail!("to do")
}
