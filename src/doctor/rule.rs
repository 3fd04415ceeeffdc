//! The rule by which udev gives `/dev/uinput` to whoever sits at the machine; and its installation.

use std::io::{self, Write as _};
use std::path::Path;
use std::process::Command;

use super::node::{Node, PATH};
use super::{Line, Machine};

const SUBJECT: &str = "udev rule";
/// Where rules lie; the first folder is for those of this machine.
const FOLDERS: [&str; 4] = [
    "/etc/udev/rules.d",
    "/run/udev/rules.d",
    "/usr/local/lib/udev/rules.d",
    "/usr/lib/udev/rules.d",
];
/// Rules that sort after this one tag for `uaccess` too late.
const SEAT: &str = "73-seat-late.rules";

/// gelpad's own rule.
pub const RULE: &str = include_str!("../../udev/70-gelpad.rules");
/// Its place.
pub const RULE_PATH: &str = "/etc/udev/rules.d/70-gelpad.rules";
/// What makes it hold at once.
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

/// What is known of rules.
#[derive(Clone, Debug, Default)]
pub(super) struct Rules {
    /// Whether udev runs.
    udev: bool,
    /// Rules about uinput: folder, file and text.
    about: Vec<(String, String, String)>,
}

pub(super) fn look(machine: &Machine) -> Rules {
    let mut about = Vec::new();
    for folder in FOLDERS {
        for file in machine.names(folder) {
            let text = machine.text(&format!("{folder}/{file}"));
            let text = text.unwrap_or_default();
            let rules = text
                .lines()
                .filter(|line| !line.trim_start().starts_with('#'));
            for rule in rules.filter(|line| line.contains("KERNEL==\"uinput\"")) {
                about.push((folder.to_owned(), file.clone(), rule.to_owned()));
            }
        }
    }
    Rules {
        udev: machine.exists("/run/udev/control"),
        about,
    }
}

pub(super) fn judge(rules: &Rules, node: &Node) -> Line {
    let gives = |rule: &str| rule.contains("uaccess") || rule.contains("GROUP=");
    let given = rules.about.iter().find(|(_, _, rule)| gives(rule));
    let late = |file: &str, rule: &str| rule.contains("uaccess") && file > SEAT;
    match given {
        Some((folder, file, rule)) if late(file, rule) => Line::wrong(
            SUBJECT,
            format!("{folder}/{file} comes too late: `uaccess` must sort before {SEAT}"),
            format!("sudo mv {folder}/{file} {folder}/70-{}", unnumbered(file)),
        ),
        Some((folder, file, _)) => Line::ok(SUBJECT, format!("{folder}/{file}")),
        None if !rules.udev => Line::note(SUBJECT, "none, and no udev runs here: a container?"),
        None if *node == Node::Writable => {
            Line::note(SUBJECT, format!("none, and none needed: {PATH} is yours"))
                .mend("gelpad doctor --install-rule (for FTDI adapters, and other users)")
        }
        None => Line::wrong(
            SUBJECT,
            format!("none gives {PATH} to who sits here"),
            "gelpad doctor --install-rule",
        ),
    }
}

/// A rule's name without the number before it.
fn unnumbered(file: &str) -> &str {
    file.trim_start_matches(|c: char| c.is_ascii_digit() || c == '-')
}

/// Writes the rule, whole or not at all, under a root.
///
/// # Errors
/// No permission, mostly.
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

/// Makes it hold at once; what did not work is told by its words.
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
    use crate::doctor::State;

    fn judged(file: &str, rule: &str, node: &Node) -> Line {
        let folder = tempfile::tempdir().expect("a folder");
        let place = folder.path().join("etc/udev/rules.d");
        std::fs::create_dir_all(&place).expect("a folder");
        std::fs::create_dir_all(folder.path().join("run/udev")).expect("a folder");
        std::fs::write(folder.path().join("run/udev/control"), "").expect("a file");
        std::fs::write(place.join(file), rule).expect("a rule");
        judge(&look(&Machine::under(folder.path(), &[])), node)
    }

    #[test]
    fn a_rule_must_be_there_give_access_and_come_in_time() {
        let refused = Node::Refused {
            owned: "root:root 600".to_owned(),
        };
        let uaccess = "KERNEL==\"uinput\", TAG+=\"uaccess\"";
        assert_eq!(judged("70-x.rules", uaccess, &refused).state, State::Ok);
        let late = judged("99-x.rules", uaccess, &refused);
        assert_eq!(
            late.mend.as_deref(),
            Some("sudo mv /etc/udev/rules.d/99-x.rules /etc/udev/rules.d/70-x.rules")
        );
        let group = "KERNEL==\"uinput\", MODE=\"0660\", GROUP=\"input\"";
        assert_eq!(judged("99-x.rules", group, &refused).state, State::Ok);
        let comment = format!("# {uaccess}");
        let none = judged("70-x.rules", &comment, &refused);
        assert_eq!(none.mend.as_deref(), Some("gelpad doctor --install-rule"));
        let needless = judged("70-x.rules", "", &Node::Writable);
        assert_eq!(needless.state, State::Note);
    }

    #[test]
    fn what_is_installed_is_found_again_and_is_in_time() {
        let folder = tempfile::tempdir().expect("a folder");
        write(folder.path()).expect("written");
        let line = judge(&look(&Machine::under(folder.path(), &[])), &Node::Missing);
        assert_eq!((line.state, line.found.as_str()), (State::Ok, RULE_PATH));
    }
}
