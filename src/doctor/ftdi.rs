//! Serial adapters of FTDI, which keep what a board sends for some milliseconds.

use super::{Line, Machine};

const DEVICES: &str = "/sys/bus/usb-serial/devices";

/// A port and how long its adapter waits, ms.
pub(super) type Timer = (String, u32);

pub(super) fn look(machine: &Machine) -> Vec<Timer> {
    let timer = |port: String| {
        let text = machine.text(&format!("{DEVICES}/{port}/latency_timer"))?;
        Some((port, text.parse().ok()?))
    };
    machine
        .names(DEVICES)
        .into_iter()
        .filter_map(timer)
        .collect()
}

pub(super) fn judge(timers: &[Timer]) -> Vec<Line> {
    timers
        .iter()
        .map(|(port, ms)| {
            let subject = format!("{port} (FTDI)");
            match ms {
                0 | 1 => Line::ok(&subject, format!("hands readings on within {ms} ms")),
                _ => Line::wrong(
                    &subject,
                    format!("keeps readings for up to {ms} ms"),
                    format!(
                        "gelpad doctor --install-rule, or until it is unplugged: echo 1 | sudo tee {DEVICES}/{port}/latency_timer"
                    ),
                ),
            }
        })
        .collect()
}
