//! The checks of Windows: keys, rights, ports, timer and files.

mod board;
mod files;
mod keys;
mod rights;
pub mod rule;
mod timing;

use super::{CheckLine, DoctorReport, section};
use crate::platform::outputs::gamepad_driver;

/// Runs all checks on this computer. Moves the mouse by nothing.
pub(super) fn check_this_computer() -> DoctorReport {
    let can_send = keys::can_send();
    let ports = board::examine();
    DoctorReport {
        sections: vec![
            section("Keyboard", vec![keys::judge(can_send), rights::check()]),
            section("Gamepads", gamepad_lines()),
            section("Board", board::judge(&ports)),
            section("Timing", vec![timing::check()]),
            section("Files", vec![files::check()]),
        ],
        outputs: can_send
            .then_some("keyboard and mouse of Windows")
            .into_iter()
            .collect(),
        boards: board::access(&ports),
    }
}

/// What a virtual gamepad and gamepads as a source need on this computer.
#[must_use]
pub fn gamepad_lines() -> Vec<CheckLine> {
    let virtual_pad = match gamepad_driver() {
        Ok(()) => CheckLine::ok("virtual gamepad", "the driver ViGEmBus is installed"),
        Err(reason) => CheckLine::note(
            "virtual gamepad",
            format!("{reason}; keys and the mouse work without it"),
        ),
    };
    let source = match cfg!(gamepads) {
        true => CheckLine::ok("gamepads as a source", "built in"),
        false => CheckLine::note(
            "gamepads as a source",
            "this gelpad was built without them (--features gilrs)",
        ),
    };
    vec![virtual_pad, source]
}
