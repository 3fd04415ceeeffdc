//! Names of serial ports: paths of devices.

use std::path::Path;

use serialport::SerialPortInfo;

/// The name by which the system lists a port, through links; none if it does not exist.
#[must_use]
pub fn listed_name(path: &str) -> Option<String> {
    let real = std::fs::canonicalize(path).ok()?;
    Some(real.to_string_lossy().into_owned())
}

/// Whether a port that is not listed may be opened: a pseudo-terminal is a path only.
#[must_use]
pub fn may_exist(path: &str) -> bool {
    Path::new(path).exists()
}

/// The ports of this computer.
#[must_use]
pub fn all() -> Vec<SerialPortInfo> {
    // The library fails without this folder, which a container may lack.
    if !Path::new("/sys/class/tty").is_dir() {
        return Vec::new();
    }
    serialport::available_ports().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_that_is_not_listed_is_a_path() {
        assert!(may_exist("/dev/null"));
        assert!(!may_exist("/no/such/port"));
    }
}
