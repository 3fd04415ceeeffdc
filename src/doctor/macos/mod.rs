//! The checks of macOS: none but a statement of what is untested.

pub mod rule;

use super::{BoardAccess, CheckLine, DoctorReport, section};

/// What is known of this computer.
pub(super) fn check_this_computer() -> DoctorReport {
    let line = CheckLine::note("macOS", "gelpad compiles for macOS and has not run there");
    DoctorReport {
        sections: vec![section("System", vec![line])],
        outputs: vec!["keyboard and mouse of macOS"],
        boards: BoardAccess::None,
    }
}

/// What gamepads need on this computer.
#[must_use]
pub fn gamepad_lines() -> Vec<CheckLine> {
    vec![CheckLine::note(
        "virtual gamepad",
        "macOS has none without a driver",
    )]
}
