//! The file through which devices are made: whether it is there, and for whom.

use std::os::unix::fs::MetadataExt as _;

use rustix::fs::{Access, access};

use super::module::Module;
use super::{Line, Machine};

/// Where it is.
pub(super) const PATH: &str = "/dev/uinput";

/// What is known of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Node {
    /// It is not there.
    Missing,
    /// This user may write to it.
    Writable,
    /// This user may not.
    Refused {
        /// Whose it is: `root:root 600`.
        owned: String,
    },
}

pub(super) fn look(machine: &Machine) -> Node {
    let path = machine.path(PATH);
    let Ok(about) = path.metadata() else {
        return Node::Missing;
    };
    if access(&path, Access::READ_OK | Access::WRITE_OK).is_ok() {
        return Node::Writable;
    }
    let user = machine.name_of("/etc/passwd", about.uid());
    let group = machine.name_of("/etc/group", about.gid());
    Node::Refused {
        owned: format!("{user}:{group} {:o}", about.mode() & 0o777),
    }
}

pub(super) fn judge(node: &Node, module: &Module) -> Line {
    match node {
        Node::Writable => Line::ok(PATH, "yours to write"),
        Node::Refused { owned } => Line::wrong(
            PATH,
            format!("not yours to write ({owned})"),
            "gelpad doctor --install-rule",
        ),
        Node::Missing if module.loaded => Line::wrong(
            PATH,
            "not there, though the module is loaded: a container?",
            "start the container with --device /dev/uinput",
        ),
        Node::Missing => Line::wrong(
            PATH,
            "not there: the module makes it",
            "see the kernel module",
        ),
    }
}
