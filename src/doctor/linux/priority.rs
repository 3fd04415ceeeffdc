//! Whether gelpad may run before other programs on a busy computer.

use std::path::Path;

use rustix::process::{Resource, geteuid, getrlimit};

use crate::doctor::CheckLine;

const SUBJECT: &str = "priority";
/// The limit of `nice` (20 less the lowest niceness) that gelpad's threads need for -10.
const WANTED: u64 = 30;

/// What a desktop with RealtimeKit has.
const REALTIME_KIT: &str = "/usr/share/dbus-1/system-services/org.freedesktop.RealtimeKit1.service";

pub(super) fn check() -> CheckLine {
    let limit = getrlimit(Resource::Nice).current;
    judge(geteuid().is_root(), limit, Path::new(REALTIME_KIT).exists())
}

/// `limit` is none without a limit.
fn judge(is_root: bool, limit: Option<u64>, has_realtime_kit: bool) -> CheckLine {
    if is_root || limit.is_none_or(|limit| limit >= WANTED) {
        return CheckLine::ok(SUBJECT, "events are sent on time on a busy computer");
    }
    if has_realtime_kit {
        return CheckLine::ok(
            SUBJECT,
            "RealtimeKit is asked to have events sent on time on a busy computer",
        );
    }
    CheckLine::note(SUBJECT, "events may be late by 20 ms if other programs keep the computer busy")
        .with_fix("echo '@input - nice -10' | sudo tee /etc/security/limits.d/gelpad.conf; sudo usermod -aG input $USER; then log in again")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::CheckStatus;

    #[test]
    fn a_user_without_the_limit_gets_a_note_with_a_fix() {
        for (is_root, limit, has_realtime_kit) in [
            (true, Some(0), false),
            (false, Some(30), false),
            (false, None, false),
            (false, Some(0), true),
        ] {
            assert_eq!(
                judge(is_root, limit, has_realtime_kit).state,
                CheckStatus::Ok
            );
        }
        let line = judge(false, Some(0), false);
        assert_eq!(line.state, CheckStatus::Note);
        assert!(line.fix.is_some());
    }
}
