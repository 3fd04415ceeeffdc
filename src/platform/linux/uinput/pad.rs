//! An Xbox 360 pad as the kernel's own driver shows one: every game supports it.

use std::io;
use std::sync::{Arc, Mutex, PoisonError};

use evdev::uinput::VirtualDevice;
use evdev::{
    AbsInfo, AbsoluteAxisCode, AttributeSet, BusType, EventType, FFEffectCode, InputId, KeyCode,
    UinputAbsSetup,
};

use super::rumble::Rumble;
use super::{Report, builder};
use crate::types::{Action, Axis, Button, Output};

/// Name of a wired pad in the kernel's driver.
pub const PAD_NAME: &str = "Microsoft X-Box 360 pad";
/// Microsoft.
pub const PAD_VENDOR: u16 = 0x045e;
/// The wired Xbox 360 pad.
pub const PAD_PRODUCT: u16 = 0x028e;
/// As in the kernel's driver.
pub const PAD_VERSION: u16 = 0x0110;
/// Range of a stick, as in the kernel's driver.
const STICK: (i32, i32) = (-32768, 32767);
/// Value of a fully pulled trigger.
const TRIGGER: i32 = 255;
/// Fuzz and flat range of a stick, as in the kernel's driver.
const FUZZ: i32 = 16;
const FLAT: i32 = 128;
/// Rumble effects that games may upload, as many as the kernel keeps for pads without own memory.
const EFFECTS: u32 = 16;

pub(super) struct Pad {
    device: Arc<Mutex<VirtualDevice>>,
    rumble: Rumble,
    report: Report,
    dpad: Dpad,
}

impl Pad {
    pub(super) fn create() -> io::Result<Self> {
        let keys: AttributeSet<KeyCode> = Button::ALL.iter().filter_map(|b| code(*b)).collect();
        let mut device = builder()?
            .name(PAD_NAME)
            .input_id(InputId::new(
                BusType::BUS_USB,
                PAD_VENDOR,
                PAD_PRODUCT,
                PAD_VERSION,
            ))
            .with_keys(&keys)?
            .with_ff(&AttributeSet::from_iter([FFEffectCode::FF_RUMBLE]))?
            .with_ff_effects_max(EFFECTS);
        for (axis, range) in axes() {
            device = device.with_absolute_axis(&UinputAbsSetup::new(axis, range))?;
        }
        let device = Arc::new(Mutex::new(device.build()?));
        Ok(Self {
            rumble: Rumble::listen(&device)?,
            device,
            report: Report::default(),
            dpad: Dpad::default(),
        })
    }

    /// Adds a press, a release or an axis to the report.
    pub(super) fn add(&mut self, action: &Action) -> io::Result<()> {
        let (kind, code, value) = match *action {
            Action::Press(Output::Button(button)) => self.button(button, true),
            Action::Release(Output::Button(button)) => self.button(button, false),
            Action::Axis(axis, value) => {
                let (code, value) = position(axis, value);
                (EventType::ABSOLUTE, code.0, value)
            }
            _ => return Ok(()),
        };
        match self.report.add(kind, code, value) {
            Some(before) => emit(&self.device, &before),
            None => Ok(()),
        }
    }

    /// Sends the report, if it holds anything.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        if self.report.is_empty() {
            return Ok(());
        }
        emit(&self.device, &self.report.take())
    }

    /// Rumble that the game requests: strong and weak motor, 0..1.
    pub(super) fn rumble(&self) -> [f32; 2] {
        self.rumble.strength()
    }

    fn button(&mut self, button: Button, is_down: bool) -> (EventType, u16, i32) {
        match code(button) {
            Some(code) => (EventType::KEY, code.0, i32::from(is_down)),
            None => {
                let (axis, value) = self.dpad.set(button, is_down);
                (EventType::ABSOLUTE, axis.0, value)
            }
        }
    }
}

/// Which directions of the d-pad are down.
#[derive(Debug, Default)]
struct Dpad {
    up: bool,
    down: bool,
    left: bool,
    right: bool,
}

impl Dpad {
    /// The axis of the hat for a button, and its value: opposite directions cancel out.
    fn set(&mut self, button: Button, is_down: bool) -> (AbsoluteAxisCode, i32) {
        match button {
            Button::Up => self.up = is_down,
            Button::Down => self.down = is_down,
            Button::Left => self.left = is_down,
            _ => self.right = is_down,
        }
        if matches!(button, Button::Up | Button::Down) {
            let value = i32::from(self.down) - i32::from(self.up);
            (AbsoluteAxisCode::ABS_HAT0Y, value)
        } else {
            let value = i32::from(self.right) - i32::from(self.left);
            (AbsoluteAxisCode::ABS_HAT0X, value)
        }
    }
}

fn emit(device: &Mutex<VirtualDevice>, changes: &[evdev::InputEvent]) -> io::Result<()> {
    // A panic while the lock was held leaves the device as it was.
    let mut device = device.lock().unwrap_or_else(PoisonError::into_inner);
    device.emit(changes)
}

/// The kernel's code of a button; none for the d-pad, which is a hat.
///
/// The kernel's X is `BTN_NORTH` and its Y `BTN_WEST` (`BTN_X`, `BTN_Y`), regardless of their places: games expect this.
fn code(button: Button) -> Option<KeyCode> {
    Some(match button {
        Button::A => KeyCode::BTN_SOUTH,
        Button::B => KeyCode::BTN_EAST,
        Button::X => KeyCode::BTN_NORTH,
        Button::Y => KeyCode::BTN_WEST,
        Button::LeftShoulder => KeyCode::BTN_TL,
        Button::RightShoulder => KeyCode::BTN_TR,
        Button::Select => KeyCode::BTN_SELECT,
        Button::Start => KeyCode::BTN_START,
        Button::Guide => KeyCode::BTN_MODE,
        Button::LeftStick => KeyCode::BTN_THUMBL,
        Button::RightStick => KeyCode::BTN_THUMBR,
        Button::Up | Button::Down | Button::Left | Button::Right => return None,
    })
}

/// Every axis and its range.
fn axes() -> [(AbsoluteAxisCode, AbsInfo); 8] {
    use AbsoluteAxisCode as Abs;

    let stick = AbsInfo::new(0, STICK.0, STICK.1, FUZZ, FLAT, 0);
    let trigger = AbsInfo::new(0, 0, TRIGGER, 0, 0, 0);
    let hat = AbsInfo::new(0, -1, 1, 0, 0, 0);
    [
        (Abs::ABS_X, stick),
        (Abs::ABS_Y, stick),
        (Abs::ABS_Z, trigger),
        (Abs::ABS_RX, stick),
        (Abs::ABS_RY, stick),
        (Abs::ABS_RZ, trigger),
        (Abs::ABS_HAT0X, hat),
        (Abs::ABS_HAT0Y, hat),
    ]
}

/// The kernel's axis and its value; its y axes point down.
fn position(axis: Axis, value: f32) -> (AbsoluteAxisCode, i32) {
    use AbsoluteAxisCode as Abs;

    let stick = |value: f32| {
        let end = if value < 0.0 { -STICK.0 } else { STICK.1 };
        (value.clamp(-1.0, 1.0) * end as f32).round() as i32
    };
    let trigger = |value: f32| (value.clamp(0.0, 1.0) * TRIGGER as f32).round() as i32;
    match axis {
        Axis::LeftX => (Abs::ABS_X, stick(value)),
        Axis::LeftY => (Abs::ABS_Y, stick(-value)),
        Axis::RightX => (Abs::ABS_RX, stick(value)),
        Axis::RightY => (Abs::ABS_RY, stick(-value)),
        Axis::LeftTrigger => (Abs::ABS_Z, trigger(value)),
        Axis::RightTrigger => (Abs::ABS_RZ, trigger(value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_codes_are_those_of_the_kernels_own_driver() {
        // input-event-codes.h: BTN_A 0x130, BTN_X 0x133, BTN_Y 0x134, BTN_TL 0x136, BTN_THUMBR 0x13e.
        let numbers: Vec<Option<u16>> = Button::ALL
            .iter()
            .map(|button| code(*button).map(|code| code.0))
            .collect();
        let keys = [
            0x130, 0x131, 0x133, 0x134, 0x136, 0x137, 0x13a, 0x13b, 0x13c, 0x13d, 0x13e,
        ];
        assert_eq!(numbers[..11], keys.map(Some));
        assert_eq!(numbers[11..], [None; 4]);
    }

    #[test]
    fn sticks_reach_both_ends_and_up_is_negative() {
        let at = |axis, value| {
            let (code, value) = position(axis, value);
            (code.0, value)
        };
        assert_eq!(at(Axis::LeftX, -1.0), (0, -32768));
        assert_eq!(at(Axis::LeftX, 1.0), (0, 32767));
        assert_eq!(at(Axis::LeftY, 1.0), (1, -32768));
        assert_eq!(at(Axis::RightY, -1.0), (4, 32767));
        assert_eq!(at(Axis::RightX, 0.0), (3, 0));
        assert_eq!(at(Axis::LeftTrigger, 1.0), (2, 255));
        assert_eq!(at(Axis::RightTrigger, 0.5), (5, 128));
        assert_eq!(at(Axis::LeftX, 7.0), (0, 32767));
    }

    #[test]
    fn opposite_directions_of_the_dpad_cancel_out() {
        let mut dpad = Dpad::default();
        let mut set = |button, is_down| {
            let (axis, value) = dpad.set(button, is_down);
            (axis.0, value)
        };
        assert_eq!(set(Button::Up, true), (17, -1));
        assert_eq!(set(Button::Right, true), (16, 1));
        assert_eq!(set(Button::Down, true), (17, 0));
        assert_eq!(set(Button::Up, false), (17, 1));
        assert_eq!(set(Button::Left, true), (16, 0));
        assert_eq!(set(Button::Right, false), (16, -1));
    }
}
