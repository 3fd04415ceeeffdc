//! Events for output devices.

use std::fmt;

use super::{Axis, Button, Key, MouseButton, Nanos, UnknownName, ms_from_nanos};

/// Something that can be held: a key, a gamepad button or a mouse button.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Output {
    /// A key of the keyboard.
    Key(Key),
    /// A button of the gamepad.
    Button(Button),
    /// A button of the mouse.
    Mouse(MouseButton),
}

/// One change of one output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// The output goes down.
    Press(Output),
    /// The output goes up.
    Release(Output),
    /// An axis takes a value, -1..1 for sticks and 0..1 for triggers.
    Axis(Axis, f32),
    /// The mouse moves, in pixels.
    Motion {
        /// Right positive.
        dx: i32,
        /// Down positive.
        dy: i32,
    },
    /// The wheel turns, in notches.
    Wheel {
        /// Right positive.
        dx: i32,
        /// Up positive.
        dy: i32,
    },
}

/// An action and the time at which it is due.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Due time, in the time of the source.
    pub t_ns: Nanos,
    /// The action.
    pub action: Action,
}

impl fmt::Display for Output {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Key(key) => write!(f, "key:{key}"),
            Self::Button(button) => write!(f, "pad:{button}"),
            Self::Mouse(button) => write!(f, "mouse:{button}"),
        }
    }
}

impl std::str::FromStr for Output {
    type Err = UnknownName;

    fn from_str(text: &str) -> Result<Self, UnknownName> {
        match text.split_once(':') {
            Some(("key", name)) => name.parse().map(Self::Key),
            Some(("pad", name)) => name.parse().map(Self::Button),
            Some(("mouse", name)) => name.parse().map(Self::Mouse),
            _ => Err(UnknownName::without_device(text)),
        }
    }
}

/// The line of `--print events`: `12340.000 press key:space`.
impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let t_ms = ms_from_nanos(self.t_ns);
        match self.action {
            Action::Press(output) => write!(f, "{t_ms:.3} press {output}"),
            Action::Release(output) => write!(f, "{t_ms:.3} release {output}"),
            Action::Axis(axis, value) => write!(f, "{t_ms:.3} axis pad:{axis} {value:.3}"),
            Action::Motion { dx, dy } => write!(f, "{t_ms:.3} motion mouse {dx} {dy}"),
            Action::Wheel { dx, dy } => write!(f, "{t_ms:.3} wheel mouse {dx} {dy}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_print_in_the_documented_format() {
        let at = |action| Event {
            t_ns: 12_340_000_000,
            action,
        };
        let space: Output = "key:space".parse().expect("a key");
        assert_eq!(
            at(Action::Press(space)).to_string(),
            "12340.000 press key:space"
        );
        assert_eq!(
            at(Action::Release(space)).to_string(),
            "12340.000 release key:space"
        );
        assert_eq!(
            at(Action::Axis(Axis::LeftX, 0.5)).to_string(),
            "12340.000 axis pad:left-x 0.500"
        );
    }

    #[test]
    fn an_output_without_device_explains_the_format() {
        let error = "space".parse::<Output>().expect_err("no device");
        assert_eq!(
            error.to_string(),
            "`space` names no device: write `key:NAME` for a key, `pad:NAME` for a gamepad button or `mouse:NAME` for a mouse button"
        );
    }
}
