//! A systemd scope for one of the watchers: what ends gelpad's own control group (an out-of-memory killer, the end of a
//! terminal's or a launcher's unit) leaves this watcher.
//!
//! The user's systemd is asked through `busctl`, and nothing waits for its answer: without a systemd, without `busctl`, or with one
//! that hangs, the watcher stays where it is and works as before.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::platform::watch::COMMANDS;

/// The tool that sends a message to systemd; it gives up after 25 s.
const TOOL: &str = "busctl";

/// Requests a scope for this process, if it is the second watcher and the user has a systemd.
pub(super) fn request() {
    let is_second = std::env::args_os()
        .nth(1)
        .is_some_and(|command| command == COMMANDS[1]);
    let has_systemd = std::env::var_os("XDG_RUNTIME_DIR")
        .is_some_and(|folder| Path::new(&folder).join("systemd/private").exists());
    if !(is_second && has_systemd) {
        return;
    }
    let request = Command::new(TOOL)
        .args(arguments(std::process::id()))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    let waiting = request.and_then(|mut request| {
        let thread = std::thread::Builder::new().name("scope".to_owned());
        thread.spawn(move || request.wait())
    });
    if let Err(error) = waiting {
        tracing::debug!("no scope of its own: {error}");
    }
}

/// The call of `StartTransientUnit` with one property, the process, and no further units.
fn arguments(pid: u32) -> [String; 15] {
    let (unit, pid) = (format!("gelpad-guard-{pid}.scope"), pid.to_string());
    [
        "--user",
        "call",
        "org.freedesktop.systemd1",
        "/org/freedesktop/systemd1",
        "org.freedesktop.systemd1.Manager",
        "StartTransientUnit",
        "ssa(sv)a(sa(sv))",
        &unit,
        "fail",
        "1",
        "PIDs",
        "au",
        "1",
        &pid,
        "0",
    ]
    .map(str::to_owned)
}
