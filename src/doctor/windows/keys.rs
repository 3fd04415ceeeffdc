//! Whether Windows takes keys and mouse events from gelpad.

use crate::doctor::CheckLine;
use crate::platform::outputs::accepts_events;

/// Whether Windows takes events now.
pub(super) fn can_send() -> bool {
    accepts_events()
}

pub(super) fn judge(can_send: bool) -> CheckLine {
    const SUBJECT: &str = "keyboard and mouse";
    match can_send {
        true => CheckLine::ok(SUBJECT, "Windows takes events"),
        false => CheckLine::wrong(
            SUBJECT,
            "Windows refuses events",
            "run gelpad in the session of the screen, and unlock it",
        ),
    }
}
