//! What a key of a profile is: where it stands, its kind, range, default and purpose.
//!
//! A key is one constant, in the file that reads it. The reader, the schema and the guide's table take everything from
//! that constant, so its default exists once.

use std::fmt;

/// Longest time in a profile, ms.
pub(super) const LONGEST_MS: f64 = 60_000.0;

/// Where a key stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// At the top of a profile.
    Profile,
    /// At the top of a profile or of user settings.
    Setting,
    /// In user settings only.
    User,
    /// In `[[region]]`.
    Region,
    /// In `[[binding]]`.
    Binding,
    /// In `[match]`.
    Match,
}

/// The kind of a key's value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyKind {
    /// A number: least, most, unit.
    Number(f64, f64, &'static str),
    /// A whole number: least, most.
    Count(u32, u32),
    /// One of these words.
    Word(&'static [&'static str]),
    /// Any text.
    Text,
    /// A text or a list of texts.
    Texts,
    /// true or false.
    Flag,
    /// A list of `[x, y]`.
    Points,
}

/// What holds without the key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fallback {
    /// Nothing, or the key is required.
    None,
    /// A number.
    Number(f64),
    /// A word or a description.
    Words(&'static str),
    /// true or false.
    Flag(bool),
}

impl fmt::Display for Fallback {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => Ok(()),
            Self::Number(number) => number.fmt(f),
            Self::Words(words) => f.write_str(words),
            Self::Flag(flag) => flag.fmt(f),
        }
    }
}

/// A key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// Where it stands.
    pub table: Table,
    /// The kind of its value.
    pub kind: KeyKind,
    /// Shapes, gestures or modes that take it; empty for all.
    pub only: &'static [&'static str],
    /// What holds without it.
    pub default: Fallback,
    /// Its purpose, without a full stop.
    pub about: &'static str,
}

impl Key {
    pub(super) const fn new(
        name: &'static str,
        table: Table,
        kind: KeyKind,
        about: &'static str,
    ) -> Self {
        Self {
            name,
            table,
            kind,
            only: &[],
            default: Fallback::None,
            about,
        }
    }

    /// The same key with a description of what holds without it.
    pub(super) const fn or(self, description: &'static str) -> Self {
        Self {
            default: Fallback::Words(description),
            ..self
        }
    }

    /// The same key for some shapes only.
    pub(super) const fn only(self, only: &'static [&'static str]) -> Self {
        Self { only, ..self }
    }
}

/// A key with a number as its default.
#[derive(Clone, Copy, Debug)]
pub(super) struct NumberKey {
    pub key: Key,
    pub default: f64,
}

/// A key with a whole number as its default.
#[derive(Clone, Copy, Debug)]
pub(super) struct CountKey {
    pub key: Key,
    pub default: u32,
}

/// A key with true or false as its default.
#[derive(Clone, Copy, Debug)]
pub(super) struct FlagKey {
    pub key: Key,
    pub default: bool,
}

/// A key with words that stand for values; the first word is the default.
#[derive(Clone, Copy, Debug)]
pub(super) struct WordKey<T: 'static> {
    pub key: Key,
    pub values: &'static [T],
}

/// Defines keys as constants, one on each line.
macro_rules! define_keys {
    ($($(#[$meta:meta])* $vis:vis $NAME:ident: $Type:ty = $value:expr;)+) => {
        $($(#[$meta])* $vis const $NAME: $Type = $value;)+
    };
}
pub(super) use define_keys;

/// A number with a range and a default.
pub(super) const fn number(
    name: &'static str,
    table: Table,
    (least, most, unit): (f64, f64, &'static str),
    default: f64,
    about: &'static str,
) -> NumberKey {
    let key = Key {
        default: Fallback::Number(default),
        ..Key::new(name, table, KeyKind::Number(least, most, unit), about)
    };
    NumberKey { key, default }
}

/// A time in milliseconds that stands at the top of a profile or in one binding.
pub(super) const fn time_ms(name: &'static str, default_ms: f64, about: &'static str) -> NumberKey {
    number(name, Table::Setting, MS, default_ms, about)
}

/// A whole number with a range and a default.
pub(super) const fn count(
    name: &'static str,
    table: Table,
    (least, most): (u32, u32),
    default: u32,
    about: &'static str,
) -> CountKey {
    let key = Key {
        default: Fallback::Number(default as f64),
        ..Key::new(name, table, KeyKind::Count(least, most), about)
    };
    CountKey { key, default }
}

pub(super) const fn flag(
    name: &'static str,
    table: Table,
    default: bool,
    about: &'static str,
) -> FlagKey {
    let key = Key {
        default: Fallback::Flag(default),
        ..Key::new(name, table, KeyKind::Flag, about)
    };
    FlagKey { key, default }
}

/// Words and, in the same order, the values that they stand for.
pub(super) const fn word<T>(
    name: &'static str,
    table: Table,
    words: &'static [&'static str],
    values: &'static [T],
    about: &'static str,
) -> WordKey<T> {
    assert!(words.len() == values.len());
    let key = Key::new(name, table, KeyKind::Word(words), about).or(words[0]);
    WordKey { key, values }
}

/// Ranges and units.
pub(super) const MS: (f64, f64, &str) = (0.0, LONGEST_MS, "ms");
pub(super) const MM: (f64, f64, &str) = (0.0, 1000.0, "mm");
pub(super) const SHARE: (f64, f64, &str) = (0.0, 1.0, "of the pad");
pub(super) const SIZE: (f64, f64, &str) = (1e-3, 1.0, "of the pad");
pub(super) const FORCE: (f64, f64, &str) = (0.0, 1.0, "of full force");
pub(super) const FRAMES: (f64, f64, &str) = (1.0, 600.0, "frames");

/// Other words that people write for a key.
pub(super) const SYNONYMS: &[(&str, &str)] = &[
    ("action", "output"),
    ("button", "output"),
    ("debounce_ms", "bounce_keys_ms"),
    ("deadzone", "dead_zone"),
    ("flavor", "flavour"),
    ("height", "h"),
    ("inherits", "extends"),
    ("input", "from"),
    ("key", "output"),
    ("keys", "output"),
    ("long_press_ms", "hold_ms"),
    ("palm_area_mm2", "rest_area_mm2"),
    ("priority", "order"),
    ("radius", "r"),
    ("rapid_fire_hz", "turbo_hz"),
    ("regions", "region"),
    ("sensitivity", "gain"),
    ("type", "gesture"),
    ("width", "w"),
    ("z", "order"),
];
