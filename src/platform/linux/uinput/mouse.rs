//! A mouse with five buttons and a wheel with two axes.

use std::io;

use evdev::uinput::VirtualDevice;
use evdev::{AttributeSet, BusType, EventType, InputId, KeyCode, RelativeAxisCode};

use super::{Report, builder};
use crate::types::MouseButton;

/// Name of the device.
const NAME: &str = "gelpad mouse";
/// Steps of a high-resolution wheel per notch (kernel: `REL_WHEEL_HI_RES`).
const STEPS_PER_NOTCH: i32 = 120;

pub(super) struct Mouse {
    device: VirtualDevice,
    report: Report,
}

impl Mouse {
    pub(super) fn create() -> io::Result<Self> {
        let buttons: AttributeSet<KeyCode> = MouseButton::ALL.iter().map(|b| code(*b)).collect();
        let axes = AttributeSet::from_iter([
            RelativeAxisCode::REL_X,
            RelativeAxisCode::REL_Y,
            RelativeAxisCode::REL_WHEEL,
            RelativeAxisCode::REL_HWHEEL,
            RelativeAxisCode::REL_WHEEL_HI_RES,
            RelativeAxisCode::REL_HWHEEL_HI_RES,
        ]);
        let device = builder()?
            .name(NAME)
            .input_id(InputId::new(BusType::BUS_VIRTUAL, 0, 0, 1))
            .with_keys(&buttons)?
            .with_relative_axes(&axes)?
            .build()?;
        Ok(Self {
            device,
            report: Report::default(),
        })
    }

    pub(super) fn button(&mut self, button: MouseButton, is_down: bool) -> io::Result<()> {
        self.add(EventType::KEY, code(button).0, i32::from(is_down))
    }

    pub(super) fn motion(&mut self, dx: i32, dy: i32) -> io::Result<()> {
        self.relative(RelativeAxisCode::REL_X, dx)?;
        self.relative(RelativeAxisCode::REL_Y, dy)
    }

    pub(super) fn wheel(&mut self, dx: i32, dy: i32) -> io::Result<()> {
        self.relative(RelativeAxisCode::REL_HWHEEL, dx)?;
        self.relative(RelativeAxisCode::REL_HWHEEL_HI_RES, dx * STEPS_PER_NOTCH)?;
        self.relative(RelativeAxisCode::REL_WHEEL, dy)?;
        self.relative(RelativeAxisCode::REL_WHEEL_HI_RES, dy * STEPS_PER_NOTCH)
    }

    pub(super) fn flush(&mut self) -> io::Result<()> {
        if self.report.is_empty() {
            return Ok(());
        }
        self.device.emit(&self.report.take())
    }

    fn relative(&mut self, axis: RelativeAxisCode, by: i32) -> io::Result<()> {
        if by == 0 {
            return Ok(());
        }
        self.add(EventType::RELATIVE, axis.0, by)
    }

    fn add(&mut self, kind: EventType, code: u16, value: i32) -> io::Result<()> {
        match self.report.add(kind, code, value) {
            Some(before) => self.device.emit(&before),
            None => Ok(()),
        }
    }
}

fn code(button: MouseButton) -> KeyCode {
    match button {
        MouseButton::Left => KeyCode::BTN_LEFT,
        MouseButton::Right => KeyCode::BTN_RIGHT,
        MouseButton::Middle => KeyCode::BTN_MIDDLE,
        MouseButton::Back => KeyCode::BTN_SIDE,
        MouseButton::Forward => KeyCode::BTN_EXTRA,
    }
}
