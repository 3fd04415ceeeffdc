//! The device file that creates input devices: whether it exists and is writable.

use std::os::unix::fs::MetadataExt as _;

use rustix::fs::{Access, access};

use super::Machine;
use super::module::Module;
use crate::doctor::CheckLine;

/// Path of the device file.
pub(super) const PATH: &str = "/dev/uinput";

/// CheckStatus of the device file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Node {
    /// It does not exist.
    Missing,
    /// This user may write to it.
    Writable,
    /// This user may not write to it.
    Refused {
        /// Owner and mode, such as `root:root 600`.
        owner: String,
    },
}

pub(super) fn examine(machine: &Machine) -> Node {
    let path = machine.path(PATH);
    let Ok(about) = path.metadata() else {
        return Node::Missing;
    };
    if access(&path, Access::READ_OK | Access::WRITE_OK).is_ok() {
        return Node::Writable;
    }
    let user = machine.account_name("/etc/passwd", about.uid());
    let group = machine.account_name("/etc/group", about.gid());
    Node::Refused {
        owner: format!("{user}:{group} {:o}", about.mode() & 0o777),
    }
}

pub(super) fn judge(node: &Node, module: &Module) -> CheckLine {
    match node {
        Node::Writable => CheckLine::ok(PATH, "writable"),
        Node::Refused { owner } => CheckLine::wrong(
            PATH,
            format!("no write permission ({owner})"),
            "gelpad doctor --install-rule",
        ),
        Node::Missing if module.loaded => CheckLine::wrong(
            PATH,
            "missing although the module is loaded (a container?)",
            "start the container with --device /dev/uinput",
        ),
        Node::Missing => CheckLine::wrong(
            PATH,
            "missing: the kernel module creates it",
            "fix the kernel module first",
        ),
    }
}
