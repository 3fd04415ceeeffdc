//! The udev rule that gives the logged-in user access to `/dev/uinput`, and its installation.

use std::io::{self, Write as _};
use std::path::Path;
use std::process::Command;

use super::Machine;
use super::node::{Node, PATH};
use crate::doctor::CheckLine;

const SUBJECT: &str = "udev rule";
/// Folders of rules; the first is for local rules.
const FOLDERS: [&str; 4] = [
    "/etc/udev/rules.d",
    "/run/udev/rules.d",
    "/usr/local/lib/udev/rules.d",
    "/usr/lib/udev/rules.d",
];
/// `uaccess` tags of rules that sort after this one have no effect.
const SEAT_RULES: &str = "73-seat-late.rules";

/// gelpad's own rule.
pub const RULE: &str = include_str!("../../../udev/70-gelpad.rules");
/// Path of the installed rule.
pub const RULE_PATH: &str = "/etc/udev/rules.d/70-gelpad.rules";
/// Commands that apply the rule without a reboot.
pub const COMMANDS: [&[&str]; 3] = [
    &["udevadm", "control", "--reload"],
    &["udevadm", "trigger", "--subsystem-match=misc"],
    &[
        "udevadm",
        "trigger",
        "--action=add",
        "--subsystem-match=usb-serial",
    ],
];

/// The installed rules.
#[derive(Clone, Debug, Default)]
pub(super) struct Rules {
    /// Whether udev runs.
    udev: bool,
    /// Rules for uinput: folder, file, text.
    uinput: Vec<(String, String, String)>,
}

pub(super) fn examine(machine: &Machine) -> Rules {
    let mut uinput = Vec::new();
    for folder in FOLDERS {
        for file in machine.names(folder) {
            let text = machine.text(&format!("{folder}/{file}"));
            let text = text.unwrap_or_default();
            let rules = text
                .lines()
                .filter(|line| !line.trim_start().starts_with('#'));
            for rule in rules.filter(|line| line.contains("KERNEL==\"uinput\"")) {
                uinput.push((folder.to_owned(), file.clone(), rule.to_owned()));
            }
        }
    }
    Rules {
        udev: machine.exists("/run/udev/control"),
        uinput,
    }
}

pub(super) fn judge(rules: &Rules, node: &Node) -> CheckLine {
    let gives_access = |rule: &str| rule.contains("uaccess") || rule.contains("GROUP=");
    let found = rules.uinput.iter().find(|(_, _, rule)| gives_access(rule));
    let is_late = |file: &str, rule: &str| rule.contains("uaccess") && file > SEAT_RULES;
    match found {
        Some((folder, file, rule)) if is_late(file, rule) => CheckLine::wrong(
            SUBJECT,
            format!(
                "{folder}/{file} is applied too late: a rule with `uaccess` must sort before {SEAT_RULES}"
            ),
            format!(
                "sudo mv {folder}/{file} {folder}/70-{}",
                without_number(file)
            ),
        ),
        Some((folder, file, _)) => CheckLine::ok(SUBJECT, format!("{folder}/{file}")),
        None if !rules.udev => CheckLine::note(
            SUBJECT,
            "no rule, and udev does not run here (a container?)",
        ),
        None if *node == Node::Writable => CheckLine::note(
            SUBJECT,
            format!("no rule, and none needed: {PATH} is writable"),
        )
        .with_fix("gelpad doctor --install-rule (for FTDI adapters and other users)"),
        None => CheckLine::wrong(
            SUBJECT,
            format!("no rule gives you access to {PATH}"),
            "gelpad doctor --install-rule",
        ),
    }
}

/// Name of a rule file without its leading number.
fn without_number(file: &str) -> &str {
    file.trim_start_matches(|c: char| c.is_ascii_digit() || c == '-')
}

/// Writes the rule atomically under a root folder.
///
/// # Errors
/// Mostly: no permission.
pub fn write(root: &Path) -> io::Result<()> {
    let path = root.join(RULE_PATH.trim_start_matches('/'));
    let folder = path.parent().unwrap_or(root);
    std::fs::create_dir_all(folder)?;
    let mut fresh = tempfile::Builder::new()
        .permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644))
        .tempfile_in(folder)?;
    fresh.write_all(RULE.as_bytes())?;
    fresh.persist(&path).map_err(|error| error.error)?;
    Ok(())
}

/// Applies the rule; returns the commands that failed, with the reason.
#[must_use]
pub fn apply() -> Vec<String> {
    let run = |command: &&[&str]| {
        let words = command.join(" ");
        match Command::new(command[0]).args(&command[1..]).status() {
            Ok(status) if status.success() => None,
            Ok(status) => Some(format!("{words}: {status}")),
            Err(error) => Some(format!("{words}: {error}")),
        }
    };
    COMMANDS.iter().filter_map(run).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::CheckStatus;

    fn judged(file: &str, rule: &str, node: &Node) -> CheckLine {
        let folder = tempfile::tempdir().expect("a folder");
        let place = folder.path().join("etc/udev/rules.d");
        std::fs::create_dir_all(&place).expect("a folder");
        std::fs::create_dir_all(folder.path().join("run/udev")).expect("a folder");
        std::fs::write(folder.path().join("run/udev/control"), "").expect("a file");
        std::fs::write(place.join(file), rule).expect("a rule");
        judge(&examine(&Machine::at_root(folder.path(), &[])), node)
    }

    #[test]
    fn a_rule_must_exist_give_access_and_sort_early() {
        let refused = Node::Refused {
            owner: "root:root 600".to_owned(),
        };
        let uaccess = "KERNEL==\"uinput\", TAG+=\"uaccess\"";
        assert_eq!(
            judged("70-x.rules", uaccess, &refused).state,
            CheckStatus::Ok
        );
        let late = judged("99-x.rules", uaccess, &refused);
        assert_eq!(
            late.fix.as_deref(),
            Some("sudo mv /etc/udev/rules.d/99-x.rules /etc/udev/rules.d/70-x.rules")
        );
        let group = "KERNEL==\"uinput\", MODE=\"0660\", GROUP=\"input\"";
        assert_eq!(judged("99-x.rules", group, &refused).state, CheckStatus::Ok);
        let comment = format!("# {uaccess}");
        let none = judged("70-x.rules", &comment, &refused);
        assert_eq!(none.fix.as_deref(), Some("gelpad doctor --install-rule"));
        let needless = judged("70-x.rules", "", &Node::Writable);
        assert_eq!(needless.state, CheckStatus::Note);
    }

    #[test]
    fn the_installed_rule_is_found() {
        let folder = tempfile::tempdir().expect("a folder");
        write(folder.path()).expect("written");
        let line = judge(
            &examine(&Machine::at_root(folder.path(), &[])),
            &Node::Missing,
        );
        assert_eq!(
            (line.state, line.found.as_str()),
            (CheckStatus::Ok, RULE_PATH)
        );
    }
}
