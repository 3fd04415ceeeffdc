//! The kernel's module that makes input devices.

use super::{Line, Machine};

const SUBJECT: &str = "kernel module";

/// What is known of the module.
#[derive(Clone, Debug)]
pub(super) struct Module {
    /// The kernel's release.
    release: String,
    pub(super) loaded: bool,
    /// Whether the kernel comes with it; none if its modules are not here to be looked at.
    available: Option<bool>,
}

pub(super) fn look(machine: &Machine) -> Module {
    let release = machine
        .text("/proc/sys/kernel/osrelease")
        .unwrap_or_default();
    let lists = ["modules.dep", "modules.builtin"]
        .map(|list| machine.text(&format!("/lib/modules/{release}/{list}")));
    let names = |list: &String| list.contains("/uinput.ko");
    Module {
        loaded: machine.exists("/sys/class/misc/uinput"),
        available: lists[0]
            .is_some()
            .then(|| lists.iter().flatten().any(names)),
        release,
    }
}

pub(super) fn judge(module: &Module) -> Line {
    let release = &module.release;
    match (module.loaded, module.available) {
        (true, _) => Line::ok(SUBJECT, format!("uinput is loaded (Linux {release})")),
        (false, Some(true)) => Line::wrong(SUBJECT, "uinput is not loaded", "sudo modprobe uinput"),
        (false, Some(false)) => Line::wrong(
            SUBJECT,
            format!("the kernel {release} comes without uinput, as kernels for clouds do"),
            "sudo apt install linux-image-amd64, and start that kernel",
        ),
        (false, None) => Line::wrong(
            SUBJECT,
            format!(
                "uinput is not loaded, and the modules of {release} are not here: a container?"
            ),
            "sudo modprobe uinput, on the machine that runs the kernel",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::State;

    fn module(loaded: bool, available: Option<bool>) -> Module {
        Module {
            release: "6.1.0".to_owned(),
            loaded,
            available,
        }
    }

    #[test]
    fn a_module_that_is_not_loaded_is_told_from_one_that_is_not_there() {
        assert_eq!(judge(&module(true, None)).state, State::Ok);
        let faults = [Some(true), Some(false), None].map(|available| {
            let line = judge(&module(false, available));
            assert_eq!(line.state, State::Wrong);
            line.mend.expect("a command")
        });
        assert_eq!(faults[0], "sudo modprobe uinput");
        assert!(faults[1].contains("apt install"), "{}", faults[1]);
        assert!(faults[2].contains("on the machine"), "{}", faults[2]);
    }
}
