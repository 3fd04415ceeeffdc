//! A stroke in one direction.

use super::definition::{BindingReader, GestureDefinition, PlayedFrom, Warning};
use super::shared_keys::{FINGERS, WAYS};
use crate::profile::keys::{Key, KeyKind, MM, NumberKey, Table, define_keys, number, time_ms};
use crate::profile::settings::{Assist, Settings};
use crate::types::Nanos;

/// Directions, counter-clockwise from the right.
const DIRECTIONS: &[&str] = &[
    "right",
    "up-right",
    "up",
    "up-left",
    "left",
    "down-left",
    "down",
    "down-right",
];
define_keys! {
    DIRECTION: Key = Key::new("direction", Table::Binding, KeyKind::Word(DIRECTIONS), "direction of the stroke");
    SWIPE_MM: NumberKey = number("swipe_mm", Table::Setting, MM, 15.0, "a stroke this long is a swipe");
    SWIPE_MS: NumberKey = time_ms("swipe_ms", 300.0, "a swipe takes less than this");
}

/// A direction on the pad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Direction {
    /// Eighths of a turn, counter-clockwise from the right.
    pub eighth: u8,
}

impl Direction {
    /// Its word in a profile.
    #[must_use]
    pub fn word(self) -> &'static str {
        DIRECTIONS[usize::from(self.eighth) % DIRECTIONS.len()]
    }
}

/// A stroke in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swipe {
    /// Its direction.
    pub direction: Direction,
    /// Number of directions: 4 or 8.
    pub ways: u8,
    /// Touches that move together.
    pub fingers: usize,
    /// Its least length.
    pub distance_mm: f64,
    /// It reaches that length sooner than this.
    pub within_ns: Nanos,
}

impl GestureDefinition for Swipe {
    const KEYS: &'static [Key] = &[DIRECTION, WAYS.key, FINGERS.key, SWIPE_MM.key, SWIPE_MS.key];
    const PLAYED_FROM: PlayedFrom = PlayedFrom::TouchesOnly;

    fn read(binding: &mut BindingReader<'_>) -> Option<Self> {
        let word = binding.reader.word(binding.entries, &DIRECTION);
        if !binding.has("direction") {
            binding.mistake_with_help(
                "direction",
                "a swipe needs a `direction`",
                "this binding",
                "write `direction = \"left\"`, or up, up-right and so on",
            );
        }
        let eighth = DIRECTIONS
            .iter()
            .position(|direction| Some(*direction) == word)? as u8;
        let is_diagonal = eighth % 2 == 1;
        let ways = binding.ways_or(if is_diagonal { 8 } else { WAYS.default });
        if is_diagonal && ways == 4 {
            binding.mistake_with_help(
                "direction",
                "a swipe with `ways = 4` cannot be diagonal",
                "a diagonal",
                "write `ways = 8`",
            );
        }
        Some(Self {
            direction: Direction { eighth },
            ways,
            fingers: binding.count(&FINGERS) as usize,
            distance_mm: binding.number(&SWIPE_MM),
            within_ns: binding.time(&SWIPE_MS),
        })
    }

    fn describe(&self) -> String {
        let direction = self.direction.word();
        match self.fingers {
            0 | 1 => format!("swipe {direction}"),
            fingers => format!("swipe {direction} with {fingers} fingers"),
        }
    }

    fn never_fires(&self, settings: &Settings) -> Option<Warning> {
        if settings.assist != Assist::Off {
            return Some(("with touch assistance a touch does not move", None));
        }
        (self.within_ns == 0).then_some(("`swipe_ms` is 0", None))
    }
}
