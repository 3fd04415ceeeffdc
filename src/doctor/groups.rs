//! The groups that give a user what udev does not.

use rustix::process::{geteuid, getgid, getgroups};

use super::{Line, Machine};

/// Groups and what they are for.
const GROUPS: [(&str, &str); 2] = [
    ("dialout", "to read a board"),
    ("input", "to read gamepads back"),
];

/// What is known of this user.
#[derive(Clone, Debug)]
pub(super) struct Groups {
    user: String,
    is_root: bool,
    /// Those of this process.
    now: Vec<String>,
    /// Those that the next login gives.
    next: Vec<String>,
}

pub(super) fn look(machine: &Machine) -> Groups {
    let uid = geteuid();
    let user = machine.name_of("/etc/passwd", uid.as_raw());
    let ids = getgroups().unwrap_or_default();
    let ids = ids.into_iter().chain([getgid()]);
    let table = machine.text("/etc/group").unwrap_or_default();
    let listed = table.lines().filter_map(|line| {
        let (group, rest) = line.split_once(':')?;
        let members = rest.rsplit(':').next()?;
        members
            .split(',')
            .any(|member| member == user)
            .then(|| group.to_owned())
    });
    Groups {
        now: ids
            .map(|id| machine.name_of("/etc/group", id.as_raw()))
            .collect(),
        next: listed.collect(),
        is_root: uid.is_root(),
        user,
    }
}

pub(super) fn judge(groups: &Groups) -> Vec<Line> {
    if groups.is_root {
        return vec![Line::ok("groups", "root needs none")];
    }
    let has = |list: &[String], name: &str| list.iter().any(|group| group == name);
    GROUPS
        .iter()
        .map(|(name, purpose)| {
            let subject = format!("group {name}");
            if has(&groups.now, name) {
                Line::ok(&subject, format!("you are in it, {purpose}"))
            } else if has(&groups.next, name) {
                Line::wrong(
                    &subject,
                    format!("you are in it from your next login on, {purpose}"),
                    "log out, and in again",
                )
            } else {
                Line::note(
                    &subject,
                    format!("you are not in it; it is one way {purpose}"),
                )
                .mend(format!(
                    "sudo usermod -aG {name} {}, and log in again",
                    groups.user
                ))
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::State;

    #[test]
    fn a_group_of_the_next_login_does_not_count_yet() {
        let groups = Groups {
            user: "anna".to_owned(),
            is_root: false,
            now: vec!["input".to_owned()],
            next: vec!["input".to_owned(), "dialout".to_owned()],
        };
        let lines = judge(&groups);
        assert_eq!(lines[0].mend.as_deref(), Some("log out, and in again"));
        assert_eq!(lines[1].state, State::Ok);
        let stranger = Groups {
            now: Vec::new(),
            next: Vec::new(),
            ..groups
        };
        assert_eq!(
            judge(&stranger)[0].mend.as_deref(),
            Some("sudo usermod -aG dialout anna, and log in again")
        );
    }
}
