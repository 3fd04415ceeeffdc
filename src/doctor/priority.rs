//! Whether gelpad may run before other programs on a busy computer.

use rustix::process::{Resource, geteuid, getrlimit};

use super::CheckLine;

const SUBJECT: &str = "priority";
/// The limit of `nice` (20 less the lowest niceness) that gelpad's threads need for -10.
const WANTED: u64 = 30;

pub(super) fn check() -> CheckLine {
    judge(geteuid().is_root(), getrlimit(Resource::Nice).current)
}

/// `limit` is none without a limit.
fn judge(is_root: bool, limit: Option<u64>) -> CheckLine {
    if is_root || limit.is_none_or(|limit| limit >= WANTED) {
        return CheckLine::ok(SUBJECT, "events are sent on time on a busy computer");
    }
    CheckLine::note(SUBJECT, "events may be late by 20 ms if other programs keep the computer busy")
        .with_fix("echo '@input - nice -10' | sudo tee /etc/security/limits.d/gelpad.conf; sudo usermod -aG input $USER; then log in again")
}

#[cfg(test)]
mod tests {
    use super::super::CheckStatus;
    use super::*;

    #[test]
    fn a_user_without_the_limit_gets_a_note_with_a_fix() {
        assert_eq!(judge(true, Some(0)).state, CheckStatus::Ok);
        assert_eq!(judge(false, Some(30)).state, CheckStatus::Ok);
        assert_eq!(judge(false, None).state, CheckStatus::Ok);
        let line = judge(false, Some(0));
        assert_eq!(line.state, CheckStatus::Note);
        assert!(line.fix.is_some());
    }
}
