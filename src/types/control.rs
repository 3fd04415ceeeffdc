//! What physical gamepads and switches say: sources that have no image.

use std::fmt;
use std::str::FromStr;

use super::{Axis, Button, Nanos, UnknownName};

/// Everything that gamepads and switches say at one moment: a button of one is a button of all.
///
/// A plain value, and always the whole state, never a change: one that is lost is made good by the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Control {
    /// When, in the source's time.
    pub t_ns: Nanos,
    /// Whether there is a device at all; when the last one goes everything is released.
    pub present: bool,
    /// Buttons that are down.
    pub buttons: Buttons,
    /// Value of each axis in the order of [`Axis::ALL`]: -1 to 1 for sticks, 0 to 1 for triggers.
    pub axes: [f32; Axis::ALL.len()],
}

/// A set of buttons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Buttons(u16);

/// A part of a gamepad that a profile can bind: `pad:a`, `pad:left-trigger`, `stick:left`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A button, or a switch.
    Button(Button),
    /// A trigger, or anything else with one axis 0 to 1.
    Trigger(Axis),
    /// A stick: its axes to the right and up.
    Stick(Axis, Axis),
}

/// Sticks and triggers by name; the names of buttons are their own.
const AXES: &[(&str, Part)] = &[
    ("pad:left-trigger", Part::Trigger(Axis::LeftTrigger)),
    ("pad:right-trigger", Part::Trigger(Axis::RightTrigger)),
    ("stick:left", Part::Stick(Axis::LeftX, Axis::LeftY)),
    ("stick:right", Part::Stick(Axis::RightX, Axis::RightY)),
];

impl Control {
    /// The value of an axis.
    #[must_use]
    pub fn axis(&self, axis: Axis) -> f32 {
        self.axes[axis as usize]
    }

    /// How far a part is moved: to the right and up for a stick, else 0 to 1 and nothing.
    #[must_use]
    pub fn moved(&self, part: Part) -> [f64; 2] {
        match part {
            Part::Button(button) => [f64::from(u8::from(self.buttons.contains(button))), 0.0],
            Part::Trigger(axis) => [f64::from(self.axis(axis)), 0.0],
            Part::Stick(x, y) => [x, y].map(|axis| f64::from(self.axis(axis))),
        }
    }
}

impl Buttons {
    /// The same, and a button.
    #[must_use]
    pub fn with(self, button: Button) -> Self {
        Self(self.0 | 1 << button as u16)
    }

    /// The same without a button.
    #[must_use]
    pub fn without(self, button: Button) -> Self {
        Self(self.0 & !(1 << button as u16))
    }

    /// Whether a button is among them.
    #[must_use]
    pub fn contains(self, button: Button) -> bool {
        self.0 & 1 << button as u16 != 0
    }

    /// A bit a button, in the order of [`Button::ALL`]: for recordings.
    #[must_use]
    pub fn bits(self) -> u16 {
        self.0
    }

    /// From such bits; those of no button are left out.
    #[must_use]
    pub fn from_bits(bits: u16) -> Self {
        Self(bits & ((1 << Button::ALL.len()) - 1))
    }
}

impl fmt::Display for Part {
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

impl FromStr for Part {
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
    fn every_part_reads_back_as_itself() {
        let buttons = Button::ALL.iter().copied().map(Part::Button);
        for part in buttons.chain(AXES.iter().map(|(_, part)| *part)) {
            assert_eq!(part.to_string().parse(), Ok(part));
        }
        let unknown = "stick:lfet".parse::<Part>().expect_err("misspelt");
        assert_eq!(unknown.suggestion.as_deref(), Some("stick:left"));
    }

    #[test]
    fn bits_keep_every_button_and_nothing_else() {
        for button in Button::ALL {
            let only = Buttons::default().with(*button);
            assert!(Buttons::from_bits(only.bits()).contains(*button));
            assert_eq!(only.without(*button), Buttons::default());
        }
        let all = Buttons::from_bits(u16::MAX);
        assert_eq!(all.bits().count_ones() as usize, Button::ALL.len());
    }
}
