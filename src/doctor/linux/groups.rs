//! Groups that give a user access to boards and gamepads without a udev rule.

use rustix::process::{geteuid, getgid, getgroups};

use super::Machine;
use crate::doctor::CheckLine;

/// Groups and what they allow.
const GROUPS: [(&str, &str); 2] = [
    ("dialout", "access to boards"),
    ("input", "access to gamepads"),
];

/// The groups of this user.
#[derive(Clone, Debug)]
pub(super) struct Groups {
    user: String,
    is_root: bool,
    /// Of this process.
    active: Vec<String>,
    /// From the next login.
    next: Vec<String>,
}

pub(super) fn examine(machine: &Machine) -> Groups {
    let uid = geteuid();
    let user = machine.account_name("/etc/passwd", uid.as_raw());
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
        active: ids
            .map(|id| machine.account_name("/etc/group", id.as_raw()))
            .collect(),
        next: listed.collect(),
        is_root: uid.is_root(),
        user,
    }
}

pub(super) fn judge(groups: &Groups) -> Vec<CheckLine> {
    if groups.is_root {
        return vec![CheckLine::ok("groups", "root needs no groups")];
    }
    let has = |list: &[String], name: &str| list.iter().any(|group| group == name);
    GROUPS
        .iter()
        .map(|(name, purpose)| {
            let subject = format!("group {name}");
            if has(&groups.active, name) {
                CheckLine::ok(&subject, format!("member: {purpose}"))
            } else if has(&groups.next, name) {
                CheckLine::wrong(
                    &subject,
                    format!("member from the next login: {purpose}"),
                    "log out and in again",
                )
            } else {
                CheckLine::note(
                    &subject,
                    format!("not a member; membership gives {purpose}"),
                )
                .with_fix(format!(
                    "sudo usermod -aG {name} {}, then log in again",
                    groups.user
                ))
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::CheckStatus;

    #[test]
    fn a_group_from_the_next_login_does_not_count_yet() {
        let groups = Groups {
            user: "anna".to_owned(),
            is_root: false,
            active: vec!["input".to_owned()],
            next: vec!["input".to_owned(), "dialout".to_owned()],
        };
        let lines = judge(&groups);
        assert_eq!(lines[0].fix.as_deref(), Some("log out and in again"));
        assert_eq!(lines[1].state, CheckStatus::Ok);
        let no_member = Groups {
            active: Vec::new(),
            next: Vec::new(),
            ..groups
        };
        assert_eq!(
            judge(&no_member)[0].fix.as_deref(),
            Some("sudo usermod -aG dialout anna, then log in again")
        );
    }
}
