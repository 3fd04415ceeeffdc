//! Names of keys: the same words in profiles, traces and recordings, on every operating system and every backend.
//!
//! A key is identified by its Linux evdev code (`input-event-codes.h`), which is a position on the keyboard, not a symbol:
//! X11 keycodes are that code plus 8, and keymaps stay unchanged.

use std::fmt;
use std::str::FromStr;

use super::UnknownName;

/// A key by its position on the keyboard.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(u16);

/// X11 keycodes are evdev codes plus this, and have eight bits.
const X11_OFFSET: u16 = 8;

/// Names and evdev codes. The first name of a code is the one that is printed.
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
    // Between left shift and z on European keyboards.
    ("intl-backslash", 86), ("f11", 87), ("f12", 88),
    // Japanese keyboards.
    ("intl-ro", 89), ("katakana", 90), ("hiragana", 91), ("convert", 92), ("kana-mode", 93), ("non-convert", 94),
    ("keypad-enter", 96), ("right-ctrl", 97), ("keypad-divide", 98), ("print-screen", 99),
    ("right-alt", 100), ("home", 102), ("up", 103), ("page-up", 104), ("left", 105), ("right", 106),
    ("end", 107), ("down", 108), ("page-down", 109), ("insert", 110), ("delete", 111),
    ("mute", 113), ("volume-down", 114), ("volume-up", 115), ("keypad-equal", 117), ("pause", 119), ("keypad-comma", 121),
    // Korean and Japanese keyboards.
    ("hangul", 122), ("hanja", 123), ("intl-yen", 124),
    ("left-meta", 125), ("right-meta", 126), ("menu", 127),
    ("undo", 131), ("copy", 133), ("open", 134), ("paste", 135), ("find", 136), ("cut", 137), ("help", 138),
    ("calculator", 140), ("mail", 155), ("browser-back", 158), ("browser-forward", 159), ("eject", 161),
    ("media-next", 163), ("media-play-pause", 164), ("media-previous", 165), ("media-stop", 166), ("media-record", 167),
    ("media-rewind", 168), ("browser-home", 172), ("browser-refresh", 173), ("keypad-left-paren", 179), ("keypad-right-paren", 180),
    ("f13", 183), ("f14", 184), ("f15", 185), ("f16", 186), ("f17", 187), ("f18", 188),
    ("f19", 189), ("f20", 190), ("f21", 191), ("f22", 192), ("f23", 193), ("f24", 194),
    ("media-play", 207), ("media-fast-forward", 208), ("browser-search", 217), ("brightness-down", 224), ("brightness-up", 225),
];

impl Key {
    /// All keys in the order of their codes.
    pub fn all() -> impl Iterator<Item = Self> {
        let mut before = 0;
        KEYS.iter()
            .map(|(_, code)| *code)
            .filter(move |code| std::mem::replace(&mut before, *code) != *code)
            .map(Self)
    }

    /// The Linux evdev code.
    #[must_use]
    pub fn evdev_code(self) -> u16 {
        self.0
    }

    /// Whether the key is a modifier: shift, ctrl, alt or meta.
    #[must_use]
    pub fn is_modifier(self) -> bool {
        matches!(self.0, 29 | 42 | 54 | 56 | 97 | 100 | 125 | 126)
    }

    /// The X11 keycode: the evdev code plus 8.
    #[must_use]
    pub fn x11_keycode(self) -> u8 {
        u8::try_from(self.0 + X11_OFFSET).unwrap_or(u8::MAX)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_parses_to_its_key() {
        for (name, code) in KEYS {
            let key: Key = name.parse().expect("a listed key");
            assert_eq!(key.evdev_code(), *code);
            assert_eq!(key.to_string().parse::<Key>(), Ok(key));
        }
    }

    #[test]
    fn every_key_is_listed_once_and_has_an_x11_keycode() {
        let all: Vec<Key> = Key::all().collect();
        assert!(
            all.is_sorted() && all.len() == KEYS.len() - 1,
            "`return` is `enter`"
        );
        assert!(all.windows(2).all(|pair| pair[0] != pair[1]));
        assert!(all.iter().all(|key| key.evdev_code() + X11_OFFSET <= 255));
    }

    #[test]
    fn a_misspelt_name_suggests_the_nearest_one() {
        let suggestion = |text: &str| text.parse::<Key>().expect_err("misspelt").suggestion;
        assert_eq!(suggestion("spcae"), Some("space".to_owned()));
        assert_eq!(suggestion("left-shfit"), Some("left-shift".to_owned()));
        assert_eq!(suggestion("qqqqqqq"), None);
        assert_eq!(suggestion("F"), Some("f".to_owned()));
        assert_eq!(suggestion(";"), None);
    }
}
