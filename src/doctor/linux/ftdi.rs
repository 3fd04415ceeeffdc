//! FTDI serial adapters: their latency timer holds received bytes back for up to 16 ms.

use super::Machine;
use crate::doctor::CheckLine;

const DEVICES: &str = "/sys/bus/usb-serial/devices";

pub(super) fn check(machine: &Machine) -> Vec<CheckLine> {
    let line = |port: String| {
        let timer = format!("{DEVICES}/{port}/latency_timer");
        let ms: u32 = machine.text(&timer)?.parse().ok()?;
        let subject = format!("{port} (FTDI)");
        Some(match ms {
            0 | 1 => CheckLine::ok(&subject, format!("latency timer {ms} ms")),
            _ => CheckLine::wrong(
                &subject,
                format!("latency timer {ms} ms: frames arrive up to {ms} ms late"),
                format!(
                    "gelpad doctor --install-rule; or, until the adapter is unplugged: echo 1 | sudo tee {timer}"
                ),
            ),
        })
    };
    let ports = machine.names(DEVICES);
    ports.into_iter().filter_map(line).collect()
}
