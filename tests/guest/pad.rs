//! Actions on gelpad's pad, and what every reader must see of them.

use anyhow::Result;
use gelpad::output::OutputDevice as _;
use gelpad::platform::linux::uinput::Uinput;
use gelpad::types::{Action, Axis, Button, Event, Output};

/// One action on the pad.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub action: Action,
    /// Type, code and value of the kernel's event, as the driver of the real pad sends it.
    pub kernel: (u16, u16, i32),
    /// Its name and value in SDL2.
    pub sdl: (&'static str, i32),
}

const KEY: u16 = 1;
const ABS: u16 = 3;

/// Every button, the hat and both ends of every axis, each followed by its release.
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (button, code, sdl) in [
        (Button::A, 0x130, "a"),
        (Button::B, 0x131, "b"),
        (Button::X, 0x133, "x"),
        (Button::Y, 0x134, "y"),
        (Button::LeftShoulder, 0x136, "leftshoulder"),
        (Button::RightShoulder, 0x137, "rightshoulder"),
        (Button::Select, 0x13a, "back"),
        (Button::Start, 0x13b, "start"),
        (Button::Guide, 0x13c, "guide"),
        (Button::LeftStick, 0x13d, "leftstick"),
        (Button::RightStick, 0x13e, "rightstick"),
    ] {
        cases.extend(held(button, (KEY, code, 1), sdl));
    }
    for (button, code, way, sdl) in [
        (Button::Up, 0x11, -1, "dpup"),
        (Button::Down, 0x11, 1, "dpdown"),
        (Button::Left, 0x10, -1, "dpleft"),
        (Button::Right, 0x10, 1, "dpright"),
    ] {
        cases.extend(held(button, (ABS, code, way), sdl));
    }
    for (axis, code, up_is_less, sdl) in [
        (Axis::LeftX, 0x00, false, "leftx"),
        (Axis::LeftY, 0x01, true, "lefty"),
        (Axis::RightX, 0x03, false, "rightx"),
        (Axis::RightY, 0x04, true, "righty"),
    ] {
        for value in [1.0, 0.0, -1.0, 0.0] {
            let way = if up_is_less { -value } else { value };
            let end = match way {
                way if way > 0.0 => 32767,
                way if way < 0.0 => -32768,
                _ => 0,
            };
            cases.push(Case {
                action: Action::Axis(axis, value),
                kernel: (ABS, code, end),
                sdl: (sdl, end),
            });
        }
    }
    for (axis, code, sdl) in [
        (Axis::LeftTrigger, 0x02, "lefttrigger"),
        (Axis::RightTrigger, 0x05, "righttrigger"),
    ] {
        for (value, kernel, seen) in [(1.0, 255, 32767), (0.0, 0, 0)] {
            cases.push(Case {
                action: Action::Axis(axis, value),
                kernel: (ABS, code, kernel),
                sdl: (sdl, seen),
            });
        }
    }
    cases
}

fn held(button: Button, (kind, code, value): (u16, u16, i32), sdl: &'static str) -> [Case; 2] {
    let output = Output::Button(button);
    [
        (Action::Press(output), value, 1),
        (Action::Release(output), 0, 0),
    ]
    .map(|(action, value, seen)| Case {
        action,
        kernel: (kind, code, value),
        sdl: (sdl, seen),
    })
}

/// Sends one action and flushes it.
pub fn send(pad: &mut Uinput, action: Action) -> Result<()> {
    pad.send(&Event { t_ns: 0, action })?;
    Ok(pad.flush()?)
}
