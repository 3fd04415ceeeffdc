//! The pad as read by gilrs, which many games in Rust use.

use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};
use gelpad::platform::linux::uinput::Uinput;
use gelpad::types::{Action, Axis, Button, Output};
use gilrs::{EventType, Gilrs};

use crate::pad::{cases, send};

/// Longest wait for one event: the guest is slow, and a missing event must not hang the test.
const WAIT: Duration = Duration::from_millis(100);
/// Number of waits: udev takes long where several guests share a computer.
const PATIENCE: usize = 900;

pub fn read() -> Result<()> {
    let mut pad = Uinput::create()?;
    let mut gilrs = match Gilrs::new() {
        Ok(gilrs) => gilrs,
        Err(error) => bail!("gilrs: {error}"),
    };
    if gilrs.gamepads().next().is_none() {
        wait(&mut gilrs, |event| *event == EventType::Connected)
            .context("the pad is plugged in")?;
    }
    let Some((_, gamepad)) = gilrs.gamepads().next() else {
        bail!("gilrs finds no gamepad");
    };
    let found = (gamepad.os_name(), gamepad.map_name());
    ensure!(
        found.0 == "Microsoft X-Box 360 pad" && found.1.is_some(),
        "gilrs takes the pad for {found:?}"
    );
    println!("gilrs: {}, mapped as {:?}", found.0, found.1);
    for case in cases() {
        send(&mut pad, case.action)?;
        wait(&mut gilrs, |event| is(event, case.action))
            .with_context(|| format!("{:?}", case.action))?;
    }
    drop(pad);
    wait(&mut gilrs, |event| *event == EventType::Disconnected).context("the pad is gone")?;
    Ok(())
}

/// Waits for an event; no button may be pressed before it.
fn wait(gilrs: &mut Gilrs, is_it: impl Fn(&EventType) -> bool) -> Result<()> {
    // gilrs wakes up without an event when other devices come and go.
    for _ in 0..PATIENCE {
        let Some(event) = gilrs.next_event_blocking(Some(WAIT)) else {
            continue;
        };
        if is_it(&event.event) {
            return Ok(());
        }
        if let EventType::ButtonPressed(button, _) = event.event {
            bail!("{button:?} was pressed instead");
        }
    }
    bail!("nothing came")
}

fn is(event: &EventType, action: Action) -> bool {
    match (action, event) {
        (Action::Press(output), EventType::ButtonPressed(seen, _))
        | (Action::Release(output), EventType::ButtonReleased(seen, _)) => {
            Some(*seen) == button(output)
        }
        (Action::Axis(axis, value), EventType::AxisChanged(seen, at, _)) => {
            Some(*seen) == stick(axis) && (at - value).abs() < 1e-3
        }
        // A trigger that is fully pulled or released is reported as a button only.
        (Action::Axis(axis, value), EventType::ButtonPressed(seen, _)) => {
            Some(*seen) == trigger(axis) && value == 1.0
        }
        (Action::Axis(axis, value), EventType::ButtonReleased(seen, _)) => {
            Some(*seen) == trigger(axis) && value == 0.0
        }
        _ => false,
    }
}

fn button(output: Output) -> Option<gilrs::Button> {
    use gilrs::Button as Seen;

    let Output::Button(button) = output else {
        return None;
    };
    Some(match button {
        Button::A => Seen::South,
        Button::B => Seen::East,
        Button::X => Seen::West,
        Button::Y => Seen::North,
        Button::LeftShoulder => Seen::LeftTrigger,
        Button::RightShoulder => Seen::RightTrigger,
        Button::Select => Seen::Select,
        Button::Start => Seen::Start,
        Button::Guide => Seen::Mode,
        Button::LeftStick => Seen::LeftThumb,
        Button::RightStick => Seen::RightThumb,
        Button::Up => Seen::DPadUp,
        Button::Down => Seen::DPadDown,
        Button::Left => Seen::DPadLeft,
        Button::Right => Seen::DPadRight,
    })
}

fn stick(axis: Axis) -> Option<gilrs::Axis> {
    Some(match axis {
        Axis::LeftX => gilrs::Axis::LeftStickX,
        Axis::LeftY => gilrs::Axis::LeftStickY,
        Axis::RightX => gilrs::Axis::RightStickX,
        Axis::RightY => gilrs::Axis::RightStickY,
        Axis::LeftTrigger | Axis::RightTrigger => return None,
    })
}

fn trigger(axis: Axis) -> Option<gilrs::Button> {
    match axis {
        Axis::LeftTrigger => Some(gilrs::Button::LeftTrigger2),
        Axis::RightTrigger => Some(gilrs::Button::RightTrigger2),
        _ => None,
    }
}
