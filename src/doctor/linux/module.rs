//! The kernel module that creates input devices.

use super::Machine;
use crate::doctor::CheckLine;

const SUBJECT: &str = "kernel module";

/// CheckStatus of the `uinput` module.
#[derive(Clone, Debug)]
pub(super) struct Module {
    /// Kernel release.
    release: String,
    pub(super) loaded: bool,
    /// Whether the kernel has it; `None` if the kernel's modules are not on this file system.
    available: Option<bool>,
}

pub(super) fn examine(machine: &Machine) -> Module {
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

pub(super) fn judge(module: &Module) -> CheckLine {
    let release = &module.release;
    match (module.loaded, module.available) {
        (true, _) => CheckLine::ok(SUBJECT, format!("uinput is loaded (Linux {release})")),
        (false, Some(true)) => {
            CheckLine::wrong(SUBJECT, "uinput is not loaded", "sudo modprobe uinput")
        }
        (false, Some(false)) => CheckLine::wrong(
            SUBJECT,
            format!("kernel {release} has no uinput module (cloud kernels leave it out)"),
            "sudo apt install linux-image-amd64, then reboot into that kernel",
        ),
        (false, None) => CheckLine::wrong(
            SUBJECT,
            format!(
                "uinput is not loaded, and the modules of kernel {release} are not installed here (a container?)"
            ),
            "sudo modprobe uinput, on the machine that runs the container",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::CheckStatus;

    fn module(loaded: bool, available: Option<bool>) -> Module {
        Module {
            release: "6.1.0".to_owned(),
            loaded,
            available,
        }
    }

    #[test]
    fn an_unloaded_and_a_missing_module_have_different_fixes() {
        assert_eq!(judge(&module(true, None)).state, CheckStatus::Ok);
        let faults = [Some(true), Some(false), None].map(|available| {
            let line = judge(&module(false, available));
            assert_eq!(line.state, CheckStatus::Wrong);
            line.fix.expect("a command")
        });
        assert_eq!(faults[0], "sudo modprobe uinput");
        assert!(faults[1].contains("apt install"), "{}", faults[1]);
        assert!(faults[2].contains("on the machine"), "{}", faults[2]);
    }
}
