//! Serial ports that may be boards: whether they can be opened, and who else holds them.

use std::fs;

use rustix::fs::{Access, access};

use super::{Boards, Line, Machine};

const SUBJECT: &str = "serial ports";
/// Names of ports that boards have: adapters, boards with USB of their own, Bluetooth.
const KINDS: [&str; 3] = ["ttyUSB", "ttyACM", "rfcomm"];
/// Programs that take new ports for something else, and how to keep them away.
const GRABBERS: [(&str, &str); 2] = [
    ("ModemManager", "sudo systemctl disable --now ModemManager"),
    ("brltty", "sudo apt remove brltty"),
];

/// What is known of all ports.
#[derive(Clone, Debug)]
pub(super) struct Ports {
    ports: Vec<Port>,
    /// Those of [`GRABBERS`] that run.
    grabbers: Vec<String>,
}

#[derive(Clone, Debug)]
struct Port {
    path: String,
    /// What it says it is.
    product: String,
    accessible: bool,
    /// Who has it open: process and name.
    holders: Vec<(String, String)>,
}

pub(super) fn look(machine: &Machine) -> Ports {
    let processes: Vec<(String, String)> = machine
        .names("/proc")
        .into_iter()
        .filter(|name| name.bytes().all(|byte| byte.is_ascii_digit()))
        .filter_map(|pid| Some((machine.text(&format!("/proc/{pid}/comm"))?, pid)))
        .map(|(name, pid)| (pid, name))
        .collect();
    let is_grabber = |name: &String| GRABBERS.iter().any(|(grabber, _)| grabber == name);
    let ports = machine
        .names("/sys/class/tty")
        .into_iter()
        .filter(|name| KINDS.iter().any(|kind| name.starts_with(kind)))
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
    // The port hangs on an interface, that on the device which has a name.
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

/// Whether some board can be read.
pub(super) fn boards(ports: &Ports) -> Boards {
    let readable = |port: &Port| port.accessible && port.holders.is_empty();
    match ports.ports.as_slice() {
        [] => Boards::None,
        ports if ports.iter().any(readable) => Boards::Readable,
        _ => Boards::Unreadable,
    }
}

pub(super) fn judge(ports: &Ports) -> Vec<Line> {
    let mut lines: Vec<Line> = ports.ports.iter().map(judge_port).collect();
    if lines.is_empty() {
        lines.push(Line::note(
            SUBJECT,
            "no board is plugged in: the simulated pad plays without one",
        ));
    }
    for grabber in &ports.grabbers {
        let mend = GRABBERS.iter().find(|(name, _)| name == grabber);
        let line = Line::note(
            grabber,
            "runs, and may take a board's port when it is plugged in",
        );
        lines.push(line.mend(mend.map_or("", |(_, mend)| mend)));
    }
    lines
}

fn judge_port(port: &Port) -> Line {
    let Port { path, product, .. } = port;
    if !port.accessible {
        return Line::wrong(
            path,
            format!("{product}: not yours to read"),
            "sudo usermod -aG dialout $USER, and log in again",
        );
    }
    match port.holders.first() {
        None => Line::ok(
            path,
            format!("{product}: gelpad play --source serial:{path}"),
        ),
        Some((pid, name)) => {
            let grabber = GRABBERS.iter().find(|(grabber, _)| grabber == name);
            let mend =
                grabber.map_or_else(|| format!("kill {pid}"), |(_, mend)| (*mend).to_owned());
            Line::wrong(
                path,
                format!("{product}: held by {name} (process {pid})"),
                mend,
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::State;

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
    fn a_port_is_named_with_who_keeps_us_from_it() {
        let mend = |ports: &Ports| judge(ports)[0].mend.clone().unwrap_or_default();
        assert_eq!(judge(&port(true, &[]))[0].state, State::Ok);
        assert_eq!(boards(&port(true, &[])), Boards::Readable);
        let refused = port(false, &[]);
        assert!(mend(&refused).contains("dialout"));
        assert_eq!(boards(&refused), Boards::Unreadable);
        for (holder, expected) in [
            ("ModemManager", "sudo systemctl disable --now ModemManager"),
            ("brltty", "sudo apt remove brltty"),
            ("screen", "kill 812"),
        ] {
            let held = port(true, &[("812", holder)]);
            assert_eq!(mend(&held), expected);
            assert_eq!(boards(&held), Boards::Unreadable);
        }
    }

    #[test]
    fn a_program_that_takes_ports_is_named_before_it_does() {
        let ports = Ports {
            ports: Vec::new(),
            grabbers: vec!["brltty".to_owned()],
        };
        let lines = judge(&ports);
        assert_eq!(lines[0].state, State::Note);
        assert_eq!(lines[1].mend.as_deref(), Some("sudo apt remove brltty"));
        assert_eq!(boards(&ports), Boards::None);
    }
}
