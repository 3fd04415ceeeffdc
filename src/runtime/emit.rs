//! The output's thread: events to the device.

use rtrb::Consumer;

use super::{Due, NAP, OutputReport, nanos, new_histogram};
use crate::output::{Device, Held, OutputError};

pub(super) fn output_thread(device: Box<dyn Device>, mut events: Consumer<Due>) -> OutputReport {
    let mut held = Held::new(device);
    let mut report = OutputReport {
        presses: 0,
        latency: new_histogram(),
        error: None,
    };
    loop {
        match events.pop() {
            Ok(due) => {
                if let Err(error) = carry_out(&mut held, &due, &mut report) {
                    report.error = Some(error);
                    break;
                }
            }
            Err(_) if events.is_abandoned() && events.is_empty() => break,
            Err(_) => {
                if let Err(error) = held.flush() {
                    report.error = Some(error);
                    break;
                }
                std::thread::park_timeout(NAP);
            }
        }
    }
    report
}

fn carry_out(held: &mut Held, due: &Due, report: &mut OutputReport) -> Result<(), OutputError> {
    held.send(&due.event)?;
    if let Some(at) = due.frame_at {
        report.latency.saturating_record(nanos(at.elapsed()));
    }
    if matches!(due.event.action, crate::types::Action::Press(_)) {
        report.presses += 1;
    }
    Ok(())
}
