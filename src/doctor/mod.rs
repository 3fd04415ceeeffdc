//! Checks whether this machine can play, and names the fix for each fault.
//!
//! ```text
//! Machine ─examine─▶ facts ─judge─▶ lines: ok, note, or wrong with its fix
//! ```
//! One folder per system, one file per check. `judge` is pure, and a `Machine` of Linux can be a folder, so that tests can provoke every
//! fault. Each system's folder has `check_this_computer()`, `gamepad_lines()` and `rule`, the udev rule of Linux.

mod installation;
mod line;
#[cfg(target_os = "linux")]
pub mod linux;
#[cfg(target_os = "linux")]
use linux as system;
#[cfg(target_os = "macos")]
mod macos;
#[cfg(target_os = "macos")]
use macos as system;
#[cfg(windows)]
mod windows;
#[cfg(windows)]
use windows as system;

pub use line::{CheckLine, CheckStatus};
pub use system::{gamepad_lines, rule};

/// A section of the report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReportSection {
    /// Heading.
    pub title: &'static str,
    /// Results of its checks, at least one.
    pub lines: Vec<CheckLine>,
}

/// Results of all checks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DoctorReport {
    /// Kernel devices, desktop, board, timing.
    pub sections: Vec<ReportSection>,
    /// Outputs that work, best first.
    pub outputs: Vec<&'static str>,
    /// Whether a board can be read.
    pub boards: BoardAccess,
}

/// CheckStatus of the serial ports that may be boards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoardAccess {
    /// No board is plugged in.
    None,
    /// At least one board can be read.
    Readable,
    /// BoardAccess are plugged in, and none can be read.
    Unreadable,
}

impl DoctorReport {
    /// Whether `gelpad play` would work: an output works, and a board that is plugged in can be read.
    #[must_use]
    pub fn can_play(&self) -> bool {
        !self.outputs.is_empty() && self.boards != BoardAccess::Unreadable
    }
}

/// Runs all checks on this computer. On Linux, creates a test gamepad for about a second if possible.
#[must_use]
pub fn check_this_computer() -> DoctorReport {
    let mut report = system::check_this_computer();
    report
        .sections
        .push(section("Installation", vec![installation::check()]));
    report
}

fn section(title: &'static str, lines: Vec<CheckLine>) -> ReportSection {
    ReportSection { title, lines }
}
