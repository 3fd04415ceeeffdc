//! The pad as the kernel shows it.

use std::collections::BTreeSet;

use anyhow::{Context as _, Result, ensure};
use evdev::{BusType, Device, EventType};
use gelpad::platform::linux::uinput::Uinput;
use gelpad::types::{Action, Axis, Button, Output};

use crate::pad::{cases, send};

const NAME: &str = "Microsoft X-Box 360 pad";

/// The pad's event device, in the guest.
pub fn open() -> Result<Device> {
    evdev::enumerate()
        .map(|(_, device)| device)
        .find(|device| device.name() == Some(NAME))
        .with_context(|| format!("the kernel shows no {NAME}"))
}

/// Waits until the pad exists.
#[cfg(feature = "gilrs")]
pub fn wait_for_pad() -> Result<Device> {
    for _ in 0..600 {
        if let Ok(device) = open() {
            return Ok(device);
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    open()
}

pub fn read() -> Result<()> {
    let mut pad = Uinput::create()?;
    let mut device = open()?;
    identity(&device)?;
    for case in cases() {
        send(&mut pad, case.action)?;
        let report = report(&mut device)?;
        ensure!(
            report == [case.kernel],
            "{:?} came as {report:?} instead of {:?}",
            case.action,
            case.kernel
        );
    }
    one_report_a_state(&mut pad, &mut device)?;
    drop(pad);
    ensure!(
        report(&mut device).is_err(),
        "the pad is removed with the process that created it"
    );
    println!("{} events, each in a separate report", cases().len());
    Ok(())
}

fn identity(device: &Device) -> Result<()> {
    let id = device.input_id();
    ensure!(
        (id.bus_type(), id.vendor(), id.product(), id.version())
            == (BusType::BUS_USB, 0x045e, 0x028e, 0x0110),
        "its identity is {id:?}"
    );
    let keys: Vec<u16> = device
        .supported_keys()
        .context("no buttons")?
        .iter()
        .map(|key| key.0)
        .collect();
    let expected = [
        0x130, 0x131, 0x133, 0x134, 0x136, 0x137, 0x13a, 0x13b, 0x13c, 0x13d, 0x13e,
    ];
    ensure!(keys == expected, "its buttons are {keys:x?}");
    let axes = device.supported_absolute_axes().context("no axes")?;
    let axes: BTreeSet<u16> = axes.iter().map(|axis| axis.0).collect();
    let expected = BTreeSet::from([0, 1, 2, 3, 4, 5, 16, 17]);
    ensure!(axes == expected, "its axes are {axes:?}");
    for (axis, info) in device.get_absinfo()? {
        let range = (info.minimum(), info.maximum(), info.fuzz(), info.flat());
        let expected = match axis.0 {
            0 | 1 | 3 | 4 => (-32768, 32767, 16, 128),
            2 | 5 => (0, 255, 0, 0),
            _ => (-1, 1, 0, 0),
        };
        ensure!(range == expected, "{axis:?} has the range {range:?}");
    }
    Ok(())
}

/// Two buttons and an axis that change together are one report.
fn one_report_a_state(pad: &mut Uinput, device: &mut Device) -> Result<()> {
    use gelpad::output::OutputDevice as _;

    let state = [
        Action::Press(Output::Button(Button::A)),
        Action::Press(Output::Button(Button::B)),
        Action::Axis(Axis::LeftX, 0.5),
    ];
    for action in state {
        pad.send(&gelpad::types::Event { t_ns: 0, action })?;
    }
    pad.flush()?;
    let report = report(device)?;
    ensure!(
        report == [(1, 0x130, 1), (1, 0x131, 1), (3, 0, 16384)],
        "a state came as {report:?}"
    );
    Ok(())
}

/// The events up to the next `SYN_REPORT`, without it.
pub fn report(device: &mut Device) -> Result<Vec<(u16, u16, i32)>> {
    let mut report = Vec::new();
    loop {
        for event in device.fetch_events()? {
            if event.event_type() == EventType::SYNCHRONIZATION {
                return Ok(report);
            }
            report.push((event.event_type().0, event.code(), event.value()));
        }
    }
}
