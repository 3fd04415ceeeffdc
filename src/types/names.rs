//! Names of keys, buttons and axes: the same words in profiles, traces and recordings, on every
//! operating system.
//!
//! A key is known by its Linux evdev code (`input-event-codes.h`), which names a place on the
//! keyboard and not a symbol: X11 keycodes are that code plus 8, and no keymap is ever rewritten.

use std::fmt;
use std::str::FromStr;

/// A key, by place.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(u16);

/// Name and evdev code of every key that has a name. The first name of a code is the one printed.
#[rustfmt::skip]
const KEYS: &[(&str, u16)] = &[
    ("escape", 1),
    ("1", 2), ("2", 3), ("3", 4), ("4", 5), ("5", 6), ("6", 7), ("7", 8), ("8", 9), ("9", 10), ("0", 11),
    ("minus", 12), ("equal", 13), ("backspace", 14), ("tab", 15),
    ("q", 16), ("w", 17), ("e", 18), ("r", 19), ("t", 20), ("y", 21), ("u", 22), ("i", 23), ("o", 24), ("p", 25),
    ("left-bracket", 26), ("right-bracket", 27), ("enter", 28), ("return", 28), ("left-ctrl", 29),
    ("a", 30), ("s", 31), ("d", 32), ("f", 33), ("g", 34), ("h", 35), ("j", 36), ("k", 37), ("l", 38),
    ("semicolon", 39), ("apostrophe", 40), ("grave", 41), ("left-shift", 42), ("backslash", 43),
    ("z", 44), ("x", 45), ("c", 46), ("v", 47), ("b", 48), ("n", 49), ("m", 50),
    ("comma", 51), ("period", 52), ("slash", 53), ("right-shift", 54), ("keypad-multiply", 55),
    ("left-alt", 56), ("space", 57), ("caps-lock", 58),
    ("f1", 59), ("f2", 60), ("f3", 61), ("f4", 62), ("f5", 63), ("f6", 64), ("f7", 65), ("f8", 66), ("f9", 67), ("f10", 68),
    ("num-lock", 69), ("scroll-lock", 70),
    ("keypad-7", 71), ("keypad-8", 72), ("keypad-9", 73), ("keypad-minus", 74),
    ("keypad-4", 75), ("keypad-5", 76), ("keypad-6", 77), ("keypad-plus", 78),
    ("keypad-1", 79), ("keypad-2", 80), ("keypad-3", 81), ("keypad-0", 82), ("keypad-period", 83),
    ("f11", 87), ("f12", 88), ("keypad-enter", 96), ("right-ctrl", 97), ("keypad-divide", 98),
    ("right-alt", 100), ("home", 102), ("up", 103), ("page-up", 104), ("left", 105), ("right", 106),
    ("end", 107), ("down", 108), ("page-down", 109), ("insert", 110), ("delete", 111), ("pause", 119),
    ("left-meta", 125), ("right-meta", 126), ("menu", 127),
];

impl Key {
    /// The Linux evdev code.
    #[must_use]
    pub fn evdev_code(self) -> u16 {
        self.0
    }

    /// Whether it changes what other keys do: shift, ctrl, alt, meta.
    #[must_use]
    pub fn is_modifier(self) -> bool {
        matches!(self.0, 29 | 42 | 54 | 56 | 97 | 100 | 125 | 126)
    }

    /// The keycode of X11: the evdev code plus 8.
    #[must_use]
    pub fn x11_keycode(self) -> u16 {
        self.0 + 8
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = KEYS.iter().find(|(_, code)| *code == self.0);
        f.write_str(name.map_or("?", |(name, _)| name))
    }
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "key:{self}")
    }
}

impl FromStr for Key {
    type Err = UnknownName;

    fn from_str(text: &str) -> Result<Self, UnknownName> {
        KEYS.iter()
            .find(|(name, _)| *name == text)
            .map(|(_, code)| Self(*code))
            .ok_or_else(|| UnknownName::among("key", text, KEYS.iter().map(|(name, _)| *name)))
    }
}

/// Declares an enum whose variants have one printed name each.
macro_rules! named {
    ($(#[$doc:meta])* $type:ident, $kind:literal, { $($(#[$vdoc:meta])* $variant:ident = $name:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $type { $($(#[$vdoc])* $variant),+ }

        impl $type {
            /// All of them, in the order of their declaration.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// The name in profiles and traces.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }
        }

        impl fmt::Display for $type {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }

        impl FromStr for $type {
            type Err = UnknownName;

            fn from_str(text: &str) -> Result<Self, UnknownName> {
                Self::ALL
                    .iter()
                    .copied()
                    .find(|one| one.name() == text)
                    .ok_or_else(|| UnknownName::among($kind, text, Self::ALL.iter().map(|one| one.name())))
            }
        }
    };
}

named!(
    /// A button of a gamepad, by the names of the Xbox 360 pad.
    Button, "gamepad button", {
        /// South.
        A = "a",
        /// East.
        B = "b",
        /// West.
        X = "x",
        /// North.
        Y = "y",
        /// Left shoulder.
        LeftShoulder = "left-shoulder",
        /// Right shoulder.
        RightShoulder = "right-shoulder",
        /// Back, or select.
        Select = "select",
        /// Start.
        Start = "start",
        /// The button in the middle.
        Guide = "guide",
        /// Left stick pressed.
        LeftStick = "left-stick",
        /// Right stick pressed.
        RightStick = "right-stick",
        /// D-pad up.
        Up = "up",
        /// D-pad down.
        Down = "down",
        /// D-pad left.
        Left = "left",
        /// D-pad right.
        Right = "right",
    }
);

named!(
    /// An axis of a gamepad.
    Axis, "gamepad axis", {
        /// Left stick, right positive.
        LeftX = "left-x",
        /// Left stick, up positive.
        LeftY = "left-y",
        /// Right stick, right positive.
        RightX = "right-x",
        /// Right stick, up positive.
        RightY = "right-y",
        /// Left trigger, 0..1.
        LeftTrigger = "left-trigger",
        /// Right trigger, 0..1.
        RightTrigger = "right-trigger",
    }
);

named!(
    /// A button of the mouse.
    MouseButton, "mouse button", {
        /// The main one.
        Left = "left",
        /// The one for menus.
        Right = "right",
        /// The wheel pressed.
        Middle = "middle",
        /// The thumb's one that goes back.
        Back = "back",
        /// The thumb's one that goes on.
        Forward = "forward",
    }
);

/// A name that names nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct UnknownName {
    message: String,
    /// The known name that looks most like it.
    pub suggestion: Option<String>,
}

impl UnknownName {
    pub(crate) fn without_device(text: &str) -> Self {
        Self {
            message: format!(
                "`{text}` names no device: write `key:NAME` for a key, `pad:NAME` for a gamepad button or `mouse:NAME` for a mouse button"
            ),
            suggestion: None,
        }
    }

    pub(crate) fn among<'a>(kind: &str, text: &str, known: impl Iterator<Item = &'a str>) -> Self {
        Self {
            message: format!("no {kind} is named `{text}`"),
            suggestion: nearest(text, known),
        }
    }
}

/// The known word that takes the fewest edits (swapped neighbours are one), capitals aside, if these are fewer than half of
/// the letters.
pub(crate) fn nearest<'a>(text: &str, known: impl Iterator<Item = &'a str>) -> Option<String> {
    let lower = text.to_lowercase();
    known
        .map(|name| (strsim::osa_distance(&lower, name), name))
        .min_by_key(|(edits, _)| *edits)
        .filter(|(edits, name)| 2 * edits < name.chars().count().min(lower.chars().count()).max(1))
        .map(|(_, name)| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_reads_back_as_itself() {
        for (name, code) in KEYS {
            let key: Key = name.parse().expect("a listed key");
            assert_eq!(key.evdev_code(), *code);
            assert_eq!(key.to_string().parse::<Key>(), Ok(key));
        }
        for button in Button::ALL {
            assert_eq!(button.name().parse(), Ok(*button));
        }
    }

    #[test]
    fn a_misspelt_name_is_met_with_the_nearest_one() {
        let suggestion = |text: &str| text.parse::<Key>().expect_err("misspelt").suggestion;
        assert_eq!(suggestion("spcae"), Some("space".to_owned()));
        assert_eq!(suggestion("left-shfit"), Some("left-shift".to_owned()));
        assert_eq!(suggestion("qqqqqqq"), None);
        assert_eq!(suggestion("F"), Some("f".to_owned()));
        assert_eq!(suggestion(";"), None);
    }
}
