//! The state of physical gamepads and switches: sources without image.

use std::fmt;
use std::str::FromStr;

use super::{Axis, Button, Nanos, UnknownName};

/// The merged state of all gamepads and switches at one time.
///
/// Always the complete state, so that a lost one does no harm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Control {
    /// Time of the source.
    pub t_ns: Nanos,
    /// Whether any device is connected; outputs are released when the last one disconnects.
    pub present: bool,
    /// The buttons that are down.
    pub buttons: Buttons,
    /// The value of each axis, in the order of [`Axis::ALL`]: -1 to 1 for sticks, 0 to 1 for triggers.
    pub axes: [f32; Axis::ALL.len()],
}

/// A set of buttons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Buttons(u16);

/// A part of a gamepad that a profile can bind: `pad:a`, `pad:left-trigger`, `stick:left`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GamepadPart {
    /// A button or a switch.
    Button(Button),
    /// A trigger, or another control with one axis from 0 to 1.
    Trigger(Axis),
    /// A stick: its horizontal (right positive) and vertical (up positive) axis.
    Stick(Axis, Axis),
}

/// The names of sticks and triggers; buttons have their own.
const AXES: &[(&str, GamepadPart)] = &[
    ("pad:left-trigger", GamepadPart::Trigger(Axis::LeftTrigger)),
    (
        "pad:right-trigger",
        GamepadPart::Trigger(Axis::RightTrigger),
    ),
    ("stick:left", GamepadPart::Stick(Axis::LeftX, Axis::LeftY)),
    (
        "stick:right",
        GamepadPart::Stick(Axis::RightX, Axis::RightY),
    ),
];

impl Control {
    /// The value of an axis.
    #[must_use]
    pub fn axis(&self, axis: Axis) -> f32 {
        self.axes[axis as usize]
    }

    /// The position of a part: right and up for a stick; for others 0 to 1, and 0.
    #[must_use]
    pub fn part_position(&self, part: GamepadPart) -> [f64; 2] {
        match part {
            GamepadPart::Button(button) => {
                [f64::from(u8::from(self.buttons.contains(button))), 0.0]
            }
            GamepadPart::Trigger(axis) => [f64::from(self.axis(axis)), 0.0],
            GamepadPart::Stick(x, y) => [x, y].map(|axis| f64::from(self.axis(axis))),
        }
    }
}

impl Buttons {
    /// The set with a button added.
    #[must_use]
    pub fn with(self, button: Button) -> Self {
        Self(self.0 | 1 << button as u16)
    }

    /// The set with a button removed.
    #[must_use]
    pub fn without(self, button: Button) -> Self {
        Self(self.0 & !(1 << button as u16))
    }

    /// Whether the set contains a button.
    #[must_use]
    pub fn contains(self, button: Button) -> bool {
        self.0 & 1 << button as u16 != 0
    }

    /// One bit per button in the order of [`Button::ALL`], for recordings.
    #[must_use]
    pub fn bits(self) -> u16 {
        self.0
    }

    /// The set of such bits; unknown bits are ignored.
    #[must_use]
    pub fn from_bits(bits: u16) -> Self {
        Self(bits & ((1 << Button::ALL.len()) - 1))
    }
}

impl fmt::Display for GamepadPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Button(button) => write!(f, "pad:{button}"),
            _ => {
                let named = AXES.iter().find(|(_, part)| part == self);
                f.write_str(named.map_or("?", |(name, _)| name))
            }
        }
    }
}

impl FromStr for GamepadPart {
    type Err = UnknownName;

    fn from_str(text: &str) -> Result<Self, UnknownName> {
        let buttons = Button::ALL.iter().copied().map(Self::Button);
        let mut parts = buttons.chain(AXES.iter().map(|(_, part)| *part));
        parts
            .clone()
            .find(|part| part.to_string() == text)
            .ok_or_else(|| {
                let names: Vec<String> = parts.by_ref().map(|part| part.to_string()).collect();
                UnknownName::among("part of a gamepad", text, names.iter().map(String::as_str))
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_every_part_parses_to_the_part() {
        let buttons = Button::ALL.iter().copied().map(GamepadPart::Button);
        for part in buttons.chain(AXES.iter().map(|(_, part)| *part)) {
            assert_eq!(part.to_string().parse(), Ok(part));
        }
        let unknown = "stick:lfet".parse::<GamepadPart>().expect_err("misspelt");
        assert_eq!(unknown.suggestion.as_deref(), Some("stick:left"));
    }

    #[test]
    fn bits_contain_every_button_and_nothing_else() {
        for button in Button::ALL {
            let only = Buttons::default().with(*button);
            assert!(Buttons::from_bits(only.bits()).contains(*button));
            assert_eq!(only.without(*button), Buttons::default());
        }
        let all = Buttons::from_bits(u16::MAX);
        assert_eq!(all.bits().count_ones() as usize, Button::ALL.len());
    }
}
