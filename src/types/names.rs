//! Names of buttons and axes, the same in profiles, traces and recordings on every operating system. For keys see
//! `keys.rs`.

use std::fmt;
use std::str::FromStr;

/// Declares an enum with one name per variant.
macro_rules! named {
    ($(#[$doc:meta])* $type:ident, $kind:literal, { $($(#[$vdoc:meta])* $variant:ident = $name:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $type { $($(#[$vdoc])* $variant),+ }

        impl $type {
            /// All variants in the order of their declaration.
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
    /// A gamepad button, named as on the Xbox 360 controller.
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
        /// The middle button.
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
        /// Left, the main button.
        Left = "left",
        /// Right, for menus.
        Right = "right",
        /// The wheel pressed.
        Middle = "middle",
        /// Thumb button: back.
        Back = "back",
        /// Thumb button: forward.
        Forward = "forward",
    }
);

/// An unknown name of a key, button or axis.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct UnknownName {
    message: String,
    /// The most similar known name.
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

/// The known name with the fewest edits (swapping two neighbours is one), ignoring case, if these are fewer than half of the
/// letters.
pub(crate) fn nearest<'a>(text: &str, known: impl Iterator<Item = &'a str>) -> Option<String> {
    let lower = text.to_lowercase();
    known
        .map(|name| (strsim::osa_distance(&lower, &name.to_lowercase()), name))
        .min_by_key(|(edits, _)| *edits)
        .filter(|(edits, name)| 2 * edits < name.chars().count().min(lower.chars().count()).max(1))
        .map(|(_, name)| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_parses_to_its_button() {
        for button in Button::ALL {
            assert_eq!(button.name().parse(), Ok(*button));
        }
    }

    #[test]
    fn a_misspelt_name_suggests_the_nearest_one() {
        let suggestion = |text: &str| text.parse::<Button>().expect_err("misspelt").suggestion;
        assert_eq!(suggestion("letf"), Some("left".to_owned()));
        assert_eq!(suggestion("south"), None);
    }
}
