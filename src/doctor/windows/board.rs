//! Serial ports, and whether they can be opened.

use std::time::Duration;

use serialport::SerialPortType;

use crate::doctor::{BoardAccess, CheckLine};
use crate::platform::ports;

const SUBJECT: &str = "serial ports";
/// Any speed will do for opening a port.
const BAUD: u32 = 115_200;

/// A port that may be a board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Port {
    name: String,
    /// Name of the adapter, if Windows knows it.
    product: Option<String>,
    /// Why it cannot be opened, if it cannot.
    fault: Option<String>,
}

pub(super) fn examine() -> Vec<Port> {
    let port = |found: serialport::SerialPortInfo| {
        let product = match found.port_type {
            SerialPortType::UsbPort(usb) => usb.product,
            _ => None,
        };
        let opened = serialport::new(&found.port_name, BAUD)
            .timeout(Duration::from_millis(1))
            .open();
        Port {
            name: found.port_name,
            product,
            fault: opened.err().map(|error| error.to_string()),
        }
    };
    ports::all().into_iter().map(port).collect()
}

pub(super) fn judge(ports: &[Port]) -> Vec<CheckLine> {
    if ports.is_empty() {
        let line = CheckLine::note(
            SUBJECT,
            "none: plug in the board; if it stays so, install the driver of its USB chip",
        );
        return vec![line];
    }
    let line = |port: &Port| {
        let product = port.product.as_deref().unwrap_or("serial port");
        match &port.fault {
            None => CheckLine::ok(&port.name, product),
            Some(fault) => CheckLine::wrong(
                &port.name,
                format!("{product}: {fault}"),
                "close the program that has it open (serial monitors do), or plug the board in again",
            ),
        }
    };
    ports.iter().map(line).collect()
}

pub(super) fn access(ports: &[Port]) -> BoardAccess {
    match ports {
        [] => BoardAccess::None,
        _ if ports.iter().any(|port| port.fault.is_none()) => BoardAccess::Readable,
        _ => BoardAccess::Unreadable,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::CheckStatus;

    #[test]
    fn a_port_in_use_is_a_fault_and_one_free_port_is_enough() {
        let port = |name: &str, fault: Option<&str>| Port {
            name: name.to_owned(),
            product: None,
            fault: fault.map(str::to_owned),
        };
        let used = port("COM3", Some("Access is denied."));
        let lines = judge(std::slice::from_ref(&used));
        assert_eq!(lines[0].state, CheckStatus::Wrong);
        assert!(lines[0].fix.is_some());
        assert_eq!(access(&[]), BoardAccess::None);
        assert_eq!(access(std::slice::from_ref(&used)), BoardAccess::Unreadable);
        assert_eq!(access(&[used, port("COM4", None)]), BoardAccess::Readable);
        assert_eq!(judge(&[])[0].state, CheckStatus::Note);
    }
}
