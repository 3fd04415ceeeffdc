//! An X server without a screen.

use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result};

use crate::process::Process;

/// Longest wait for each step of the start, for a busy machine.
pub const PATIENCE: Duration = Duration::from_mins(1);
/// After SIGTERM, the X server removes its socket and lock file.
const SERVER_GRACE: Duration = Duration::from_secs(2);

/// Starts an X server on a free display that it selects itself. Without `-noreset`, it would restart whenever its last
/// client leaves and refuse clients that connect meanwhile.
pub fn start_server(xvfb: &Path, folder: &Path) -> Result<(Process, OsString)> {
    let answer = folder.join("display");
    let mut command = Command::new(xvfb);
    command
        .args(["-displayfd", "1", "-nolisten", "tcp", "-noreset"])
        .args(["-screen", "0", "1300x820x24"]);
    let mut server =
        Process::start_answering("Xvfb", &mut command, folder, &answer)?.with_grace(SERVER_GRACE);
    let number = server.wait_for("display number", PATIENCE, || {
        let text = fs::read_to_string(&answer).context("cannot read the X server's answer")?;
        Ok(text.strip_suffix('\n').map(str::to_owned))
    })?;
    Ok((server, format!(":{number}").into()))
}
