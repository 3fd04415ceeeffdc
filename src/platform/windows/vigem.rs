//! A virtual Xbox 360 gamepad, through the driver ViGEmBus.
//!
//! The driver was retired in 2023, and its last signed version still works for those who have it. When gelpad ends, however it ends,
//! the driver unplugs the gamepad: no button stays down, and no watcher is needed. Keys and the mouse go to the keyboard of Windows.
//!
//! Invariant: a batch of events is one report, so that no game sees half of a state. A button that changes twice in a batch gets two.

use vigem_client::{Client, Error, TargetId, XButtons, XGamepad, Xbox360Wired};

use crate::output::{OutputDevice, OutputError};
use crate::types::{Action, Axis, Button, Event, Output};

/// The reason why there is no virtual gamepad.
#[derive(Debug, thiserror::Error)]
pub(super) enum VigemError {
    /// The driver is not installed.
    #[error("a virtual gamepad needs the driver ViGEmBus, which is not installed")]
    NoDriver,
    /// The driver is of another version.
    #[error("the driver ViGEmBus has another version: gelpad works with 1.17 to 1.22")]
    OtherVersion,
    /// The driver or Windows refuses.
    #[error("the driver ViGEmBus refuses a gamepad: {0}")]
    Refused(#[source] Error),
}

impl From<Error> for VigemError {
    fn from(error: Error) -> Self {
        match error {
            Error::BusNotFound => Self::NoDriver,
            Error::BusVersionMismatch => Self::OtherVersion,
            other => Self::Refused(other),
        }
    }
}

impl From<VigemError> for OutputError {
    fn from(error: VigemError) -> Self {
        Self::NoDevice {
            device: "gamepad",
            reason: format!("{error}\n  help: use --output keyboard"),
        }
    }
}

/// Whether the driver is there.
pub(super) fn find_driver() -> Result<(), VigemError> {
    Client::connect()?;
    Ok(())
}

/// A gamepad that is plugged in until this is dropped, and a keyboard for keys and the mouse.
pub(super) struct Gamepad {
    target: Xbox360Wired<Client>,
    report: Report,
    keyboard: Box<dyn OutputDevice>,
}

impl Gamepad {
    /// Plugs a gamepad in.
    pub(super) fn plug_in(keyboard: Box<dyn OutputDevice>) -> Result<Self, VigemError> {
        let mut target = Xbox360Wired::new(Client::connect()?, TargetId::XBOX360_WIRED);
        target.plugin()?;
        target.wait_ready()?;
        Ok(Self {
            target,
            report: Report::default(),
            keyboard,
        })
    }

    fn submit(&mut self, state: XGamepad) -> Result<(), OutputError> {
        self.target
            .update(&state)
            .map_err(|error| OutputError::Refused {
                device: "gamepad",
                reason: error.to_string(),
            })
    }
}

impl OutputDevice for Gamepad {
    fn name(&self) -> &str {
        "gamepad of ViGEmBus, keyboard and mouse of Windows"
    }

    fn supports(&self, output: Output) -> bool {
        match output {
            Output::Button(_) => true,
            Output::Key(_) | Output::Mouse(_) => self.keyboard.supports(output),
        }
    }

    fn is_gamepad(&self) -> bool {
        true
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        let before = match event.action {
            Action::Press(Output::Button(button)) => self.report.set_button(button, true),
            Action::Release(Output::Button(button)) => self.report.set_button(button, false),
            Action::Axis(axis, value) => {
                self.report.set_axis(axis, value);
                None
            }
            _ => return self.keyboard.send(event),
        };
        match before {
            Some(state) => self.submit(state),
            None => Ok(()),
        }
    }

    fn flush(&mut self) -> Result<(), OutputError> {
        if let Some(state) = self.report.take() {
            self.submit(state)?;
        }
        self.keyboard.flush()
    }

    fn idle(&mut self) -> Result<(), OutputError> {
        self.keyboard.idle()
    }
}

/// The state of the gamepad, and what has changed since it was sent.
#[derive(Default)]
struct Report {
    state: XGamepad,
    /// Buttons that have changed.
    changed: u16,
    is_changed: bool,
}

impl Report {
    /// Presses or releases a button. If it has changed in this report already, returns that report's state, which must be sent first.
    fn set_button(&mut self, button: Button, is_down: bool) -> Option<XGamepad> {
        let bit = bit(button);
        let before = (self.changed & bit != 0).then(|| self.take()).flatten();
        let buttons = &mut self.state.buttons.raw;
        *buttons = if is_down {
            *buttons | bit
        } else {
            *buttons & !bit
        };
        self.changed |= bit;
        self.is_changed = true;
        before
    }

    /// Moves an axis: -1 to 1 for sticks, 0 to 1 for triggers. XInput's y axes point up, as ours do.
    fn set_axis(&mut self, axis: Axis, value: f32) {
        let stick = |value: f32| {
            let end = if value < 0.0 {
                -f32::from(i16::MIN)
            } else {
                f32::from(i16::MAX)
            };
            (value.clamp(-1.0, 1.0) * end).round() as i16
        };
        let trigger = |value: f32| (value.clamp(0.0, 1.0) * f32::from(u8::MAX)).round() as u8;
        match axis {
            Axis::LeftX => self.state.thumb_lx = stick(value),
            Axis::LeftY => self.state.thumb_ly = stick(value),
            Axis::RightX => self.state.thumb_rx = stick(value),
            Axis::RightY => self.state.thumb_ry = stick(value),
            Axis::LeftTrigger => self.state.left_trigger = trigger(value),
            Axis::RightTrigger => self.state.right_trigger = trigger(value),
        }
        self.is_changed = true;
    }

    /// The state, if it has changed. Nothing has changed afterwards.
    fn take(&mut self) -> Option<XGamepad> {
        self.changed = 0;
        std::mem::take(&mut self.is_changed).then_some(self.state)
    }
}

/// The bit of a button in a report of XInput.
fn bit(button: Button) -> u16 {
    match button {
        Button::A => XButtons::A,
        Button::B => XButtons::B,
        Button::X => XButtons::X,
        Button::Y => XButtons::Y,
        Button::LeftShoulder => XButtons::LB,
        Button::RightShoulder => XButtons::RB,
        Button::Select => XButtons::BACK,
        Button::Start => XButtons::START,
        Button::Guide => XButtons::GUIDE,
        Button::LeftStick => XButtons::LTHUMB,
        Button::RightStick => XButtons::RTHUMB,
        Button::Up => XButtons::UP,
        Button::Down => XButtons::DOWN,
        Button::Left => XButtons::LEFT,
        Button::Right => XButtons::RIGHT,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_button_has_a_bit_of_its_own_as_xinput_names_them() {
        // XINPUT_GAMEPAD: the d-pad in bits 0 to 3, start, back, the sticks, the shoulders, guide, and A to Y from bit 12 on.
        let bits: Vec<u16> = Button::ALL.iter().map(|button| bit(*button)).collect();
        let expected = [
            0x1000, 0x2000, 0x4000, 0x8000, 0x0100, 0x0200, 0x0020, 0x0010, 0x0400, 0x0040, 0x0080,
            0x0001, 0x0002, 0x0004, 0x0008,
        ];
        assert_eq!(bits, expected);
    }

    #[test]
    fn a_tap_within_a_batch_is_two_reports() {
        let mut report = Report::default();
        assert_eq!(report.set_button(Button::A, true), None);
        assert_eq!(report.set_button(Button::Up, true), None);
        let first = report.set_button(Button::A, false).expect("must go first");
        assert_eq!(first.buttons.raw, 0x1001);
        let second = report.take().expect("changed");
        assert_eq!(second.buttons.raw, 0x0001);
        assert_eq!(report.take(), None);
    }

    #[test]
    fn sticks_and_triggers_reach_their_ends() {
        let mut report = Report::default();
        for (axis, value) in [
            (Axis::LeftX, -1.0),
            (Axis::LeftY, 1.0),
            (Axis::RightX, 7.0),
            (Axis::RightY, -0.5),
            (Axis::LeftTrigger, 1.0),
            (Axis::RightTrigger, -1.0),
        ] {
            report.set_axis(axis, value);
        }
        let state = report.take().expect("changed");
        let sticks = [
            state.thumb_lx,
            state.thumb_ly,
            state.thumb_rx,
            state.thumb_ry,
        ];
        assert_eq!(sticks, [-32768, 32767, 32767, -16384]);
        assert_eq!([state.left_trigger, state.right_trigger], [255, 0]);
    }

    #[test]
    fn a_missing_driver_is_named_with_what_to_do() {
        let error = OutputError::from(VigemError::from(Error::BusNotFound)).to_string();
        assert!(
            error.contains("ViGEmBus, which is not installed"),
            "{error}"
        );
        assert!(error.contains("--output keyboard"), "{error}");
    }
}
