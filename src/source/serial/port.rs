//! Opening a port, and finding a board again that comes back under another name.

use std::time::Duration;

use serialport::{SerialPort, SerialPortType};

use crate::platform::ports;

/// Longest wait in one call of `read`.
pub(super) const READ_TIMEOUT: Duration = Duration::from_millis(50);

/// What identifies a board when it is plugged in elsewhere, if the system reports it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Identity {
    vendor: u16,
    product: u16,
    serial: String,
}

/// Opens a port.
pub(super) fn open(path: &str, baud: u32) -> serialport::Result<Box<dyn SerialPort>> {
    serialport::new(path, baud).timeout(READ_TIMEOUT).open()
}

/// The board at a path; none for boards without a serial number, pseudo-terminals and the like.
pub(super) fn identity(path: &str) -> Option<Identity> {
    let name = ports::listed_name(path)?;
    listed()
        .into_iter()
        .find(|(port, _)| *port == name)
        .map(|(_, identity)| identity)
}

/// The serial number of the board at a path, with its vendor and product; none for boards without one.
#[must_use]
pub fn serial_number(path: &str) -> Option<String> {
    let Identity {
        vendor,
        product,
        serial,
    } = identity(path)?;
    Some(format!("{vendor:04x}:{product:04x} {serial}"))
}

/// The present path of a board, by its serial number; without one, its former path if that exists.
pub(super) fn find(path: &str, identity: Option<&Identity>) -> Option<String> {
    find_among(path, identity, &listed())
}

fn find_among(
    path: &str,
    identity: Option<&Identity>,
    ports: &[(String, Identity)],
) -> Option<String> {
    match identity {
        Some(identity) => ports
            .iter()
            .find(|(_, there)| there == identity)
            .map(|(port, _)| port.clone()),
        None => ports::may_exist(path).then(|| path.to_owned()),
    }
}

/// Ports of boards that have a serial number.
fn listed() -> Vec<(String, Identity)> {
    ports::all()
        .into_iter()
        .filter_map(|port| match port.port_type {
            SerialPortType::UsbPort(usb) => Some((
                port.port_name,
                Identity {
                    vendor: usb.vid,
                    product: usb.pid,
                    serial: usb.serial_number.filter(|serial| !serial.is_empty())?,
                },
            )),
            _ => None,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_is_identified_by_its_number_and_not_by_its_name() {
        let board = |serial: &str| Identity {
            vendor: 0x16c0,
            product: 0x0483,
            serial: serial.to_owned(),
        };
        let ports = [
            ("/dev/ttyACM0".to_owned(), board("another")),
            ("/dev/ttyACM1".to_owned(), board("ours")),
        ];
        let find = |identity: &Identity| find_among("/dev/ttyACM0", Some(identity), &ports);
        assert_eq!(find(&board("ours")).as_deref(), Some("/dev/ttyACM1"));
        assert_eq!(
            find(&board("unplugged")),
            None,
            "another board has its name"
        );
    }
}
