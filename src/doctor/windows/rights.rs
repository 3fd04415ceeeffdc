//! Whether gelpad has fewer rights than the game: Windows drops keys for programs that run as administrator.

use crate::doctor::CheckLine;
use crate::platform::processes::{Rights, foreground_rights, own_rights};

const SUBJECT: &str = "rights";

pub(super) fn check() -> CheckLine {
    judge(own_rights(), foreground_rights())
}

fn judge(own: Rights, foreground: Option<Rights>) -> CheckLine {
    match (own, foreground) {
        (Rights::Administrator, _) => {
            CheckLine::ok(SUBJECT, "administrator: keys reach every program")
        }
        (Rights::User, Some(Rights::Administrator)) => CheckLine::wrong(
            SUBJECT,
            "the program in the foreground runs as administrator and gets no keys",
            "start the game without administrator rights, or gelpad with them",
        ),
        (Rights::User, _) => CheckLine::ok(
            SUBJECT,
            "user: keys reach every program that does not run as administrator",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::CheckStatus;

    #[test]
    fn only_a_game_with_more_rights_is_out_of_reach() {
        let state = |own, foreground| judge(own, foreground).state;
        use Rights::{Administrator, User};
        assert_eq!(state(User, Some(Administrator)), CheckStatus::Wrong);
        assert_eq!(state(User, Some(User)), CheckStatus::Ok);
        assert_eq!(state(User, None), CheckStatus::Ok);
        assert_eq!(state(Administrator, Some(Administrator)), CheckStatus::Ok);
    }
}
