//! The kind of session: what sort of desktop there is, if there is one.

use super::{Line, Machine};

const SUBJECT: &str = "session";

/// What the session says of itself.
#[derive(Clone, Debug, Default)]
pub(super) struct Session {
    kind: Option<String>,
    x11: bool,
    wayland: bool,
    remote: bool,
}

pub(super) fn look(machine: &Machine) -> Session {
    Session {
        kind: machine.setting("XDG_SESSION_TYPE").map(str::to_owned),
        x11: machine.setting("DISPLAY").is_some(),
        wayland: machine.setting("WAYLAND_DISPLAY").is_some(),
        remote: machine.setting("SSH_CONNECTION").is_some(),
    }
}

pub(super) fn judge(session: &Session) -> Line {
    let kind = session.kind.as_ref();
    let kind = kind.map_or(String::new(), |kind| format!("{kind}, "));
    match (session.wayland, session.x11) {
        (true, true) => Line::ok(SUBJECT, "Wayland, and X11 for older programs"),
        (true, false) => Line::ok(SUBJECT, "Wayland"),
        (false, true) => Line::ok(SUBJECT, "X11"),
        (false, false) if session.remote => Line::note(
            SUBJECT,
            "from afar (ssh), without a desktop: only devices of the kernel reach a game here",
        ),
        (false, false) => Line::note(
            SUBJECT,
            format!("{kind}no desktop (neither DISPLAY nor WAYLAND_DISPLAY is set)"),
        ),
    }
}
