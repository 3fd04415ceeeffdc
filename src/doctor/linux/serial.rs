//! Serial ports that may be boards: whether they can be opened, and which program has them open.

use std::fs;

use rustix::fs::{Access, access};

use super::Machine;
use crate::doctor::{BoardAccess, CheckLine};

const SUBJECT: &str = "serial ports";
/// Prefixes of the ports of boards: USB adapters, boards with USB, Bluetooth.
const PREFIXES: [&str; 3] = ["ttyUSB", "ttyACM", "rfcomm"];
/// Programs that open new ports on their own, and the command that stops them.
const PORT_GRABBERS: [(&str, &str); 2] = [
    ("ModemManager", "sudo systemctl disable --now ModemManager"),
    ("brltty", "sudo apt remove brltty"),
];

/// All ports that may be boards.
#[derive(Clone, Debug)]
pub(super) struct Ports {
    ports: Vec<Port>,
    /// Running programs of [`PORT_GRABBERS`].
    grabbers: Vec<String>,
}

#[derive(Clone, Debug)]
struct Port {
    path: String,
    /// Product name from USB.
    product: String,
    accessible: bool,
    /// Processes that have it open: id and name. Those of other users are only visible to root.
    holders: Vec<(String, String)>,
}

pub(super) fn examine(machine: &Machine) -> Ports {
    let processes: Vec<(String, String)> = machine
        .names("/proc")
        .into_iter()
        .filter(|name| name.bytes().all(|byte| byte.is_ascii_digit()))
        .filter_map(|pid| Some((machine.text(&format!("/proc/{pid}/comm"))?, pid)))
        .map(|(name, pid)| (pid, name))
        .collect();
    let is_grabber = |name: &String| PORT_GRABBERS.iter().any(|(grabber, _)| grabber == name);
    let ports = machine
        .names("/sys/class/tty")
        .into_iter()
        .filter(|name| PREFIXES.iter().any(|prefix| name.starts_with(prefix)))
        .map(|name| port(machine, &name, &processes))
        .collect();
    let names = processes.into_iter().map(|(_, name)| name);
    Ports {
        ports,
        grabbers: names.filter(is_grabber).collect(),
    }
}

fn port(machine: &Machine, name: &str, processes: &[(String, String)]) -> Port {
    let path = format!("/dev/{name}");
    // The USB device with the product name is one to three levels above the port.
    let above = ["..", "../..", "../../.."];
    let product = above
        .iter()
        .find_map(|up| machine.text(&format!("/sys/class/tty/{name}/device/{up}/product")));
    let holds = |pid: &str| {
        let folder = format!("/proc/{pid}/fd");
        machine.names(&folder).iter().any(|fd| {
            fs::read_link(machine.path(&format!("{folder}/{fd}")))
                .is_ok_and(|target| target == std::path::Path::new(&path))
        })
    };
    Port {
        accessible: access(machine.path(&path), Access::READ_OK | Access::WRITE_OK).is_ok(),
        product: product.unwrap_or_else(|| "a serial port".to_owned()),
        holders: processes
            .iter()
            .filter(|(pid, _)| holds(pid))
            .cloned()
            .collect(),
        path,
    }
}

/// Whether a board can be read.
pub(super) fn boards(ports: &Ports) -> BoardAccess {
    let readable = |port: &Port| port.accessible && port.holders.is_empty();
    match ports.ports.as_slice() {
        [] => BoardAccess::None,
        ports if ports.iter().any(readable) => BoardAccess::Readable,
        _ => BoardAccess::Unreadable,
    }
}

pub(super) fn judge(ports: &Ports) -> Vec<CheckLine> {
    let mut lines: Vec<CheckLine> = ports.ports.iter().map(judge_port).collect();
    if lines.is_empty() {
        lines.push(CheckLine::note(
            SUBJECT,
            "no board is plugged in; the simulated pad works without one",
        ));
    }
    for grabber in &ports.grabbers {
        let grabber_fix = PORT_GRABBERS.iter().find(|(name, _)| name == grabber);
        let line = CheckLine::note(grabber, "is running and may open the port of a new board");
        lines.push(line.with_fix(grabber_fix.map_or("", |(_, fix)| fix)));
    }
    lines
}

fn judge_port(port: &Port) -> CheckLine {
    let Port { path, product, .. } = port;
    if !port.accessible {
        return CheckLine::wrong(
            path,
            format!("{product}: no permission to read and write"),
            "sudo usermod -aG dialout $USER, then log in again",
        );
    }
    match port.holders.first() {
        None => CheckLine::ok(
            path,
            format!("{product}: gelpad play --source serial:{path}"),
        ),
        Some((pid, name)) => {
            let grabber = PORT_GRABBERS.iter().find(|(grabber, _)| grabber == name);
            let fix = grabber.map_or_else(|| format!("kill {pid}"), |(_, fix)| (*fix).to_owned());
            CheckLine::wrong(
                path,
                format!("{product}: in use by {name} (process {pid})"),
                fix,
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::CheckStatus;

    fn port(accessible: bool, holders: &[(&str, &str)]) -> Ports {
        let own = |(pid, name): &(&str, &str)| ((*pid).to_owned(), (*name).to_owned());
        Ports {
            ports: vec![Port {
                path: "/dev/ttyUSB0".to_owned(),
                product: "FT232R".to_owned(),
                accessible,
                holders: holders.iter().map(own).collect(),
            }],
            grabbers: Vec::new(),
        }
    }

    #[test]
    fn an_unreadable_port_is_reported_with_its_reason() {
        let fix = |ports: &Ports| judge(ports)[0].fix.clone().unwrap_or_default();
        assert_eq!(judge(&port(true, &[]))[0].state, CheckStatus::Ok);
        assert_eq!(boards(&port(true, &[])), BoardAccess::Readable);
        let refused = port(false, &[]);
        assert!(fix(&refused).contains("dialout"));
        assert_eq!(boards(&refused), BoardAccess::Unreadable);
        for (holder, expected) in [
            ("ModemManager", "sudo systemctl disable --now ModemManager"),
            ("brltty", "sudo apt remove brltty"),
            ("screen", "kill 812"),
        ] {
            let held = port(true, &[("812", holder)]);
            assert_eq!(fix(&held), expected);
            assert_eq!(boards(&held), BoardAccess::Unreadable);
        }
    }

    #[test]
    fn a_running_port_grabber_is_reported() {
        let ports = Ports {
            ports: Vec::new(),
            grabbers: vec!["brltty".to_owned()],
        };
        let lines = judge(&ports);
        assert_eq!(lines[0].state, CheckStatus::Note);
        assert_eq!(lines[1].fix.as_deref(), Some("sudo apt remove brltty"));
        assert_eq!(boards(&ports), BoardAccess::None);
    }
}
