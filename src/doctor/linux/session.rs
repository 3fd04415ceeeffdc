//! The kind of session: Wayland, X11, remote, or no desktop.

use super::Machine;
use crate::doctor::CheckLine;

const SUBJECT: &str = "session";

pub(super) fn check(machine: &Machine) -> CheckLine {
    let is_set = |name| machine.variable(name).is_some();
    match (is_set("WAYLAND_DISPLAY"), is_set("DISPLAY")) {
        (true, true) => CheckLine::ok(SUBJECT, "Wayland, with X11 for older programs"),
        (true, false) => CheckLine::ok(SUBJECT, "Wayland"),
        (false, true) => CheckLine::ok(SUBJECT, "X11"),
        (false, false) if is_set("SSH_CONNECTION") => CheckLine::note(
            SUBJECT,
            "remote (ssh), without a desktop: only kernel devices reach a game",
        ),
        (false, false) => {
            let kind = machine.variable("XDG_SESSION_TYPE");
            let kind = kind.map_or(String::new(), |kind| format!("{kind}, "));
            CheckLine::note(
                SUBJECT,
                format!("{kind}no desktop (neither DISPLAY nor WAYLAND_DISPLAY is set)"),
            )
        }
    }
}
