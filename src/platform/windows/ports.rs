//! Names of serial ports: `COM3`; from `COM10` on also `\\.\COM10`.

use serialport::SerialPortInfo;

/// The prefix of a device's path.
const DEVICE: &str = r"\\.\";

/// The name by which the system lists a port.
#[must_use]
pub fn listed_name(path: &str) -> Option<String> {
    Some(path.strip_prefix(DEVICE).unwrap_or(path).to_uppercase())
}

/// Whether a port that is not listed may be opened: only an attempt shows it.
#[must_use]
pub fn may_exist(_: &str) -> bool {
    true
}

/// The ports of this computer.
#[must_use]
pub fn all() -> Vec<SerialPortInfo> {
    serialport::available_ports().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_name_the_same_port() {
        assert_eq!(listed_name("com10").as_deref(), Some("COM10"));
        assert_eq!(listed_name(r"\\.\COM10").as_deref(), Some("COM10"));
    }
}
