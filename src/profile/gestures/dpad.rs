//! Directions from the centre of a region.

use super::definition::{BindingReader, GestureDefinition, PlayedFrom};
use super::shared_keys::{DEAD_ZONE, WAYS};
use crate::profile::keys::{Key, KeyKind, NumberKey, Table, define_keys, number};
use crate::profile::target::Target;

const fn direction(name: &'static str) -> Key {
    Key::new(
        name,
        Table::Binding,
        KeyKind::Text,
        "output of this direction",
    )
}
const DIRECTIONS: [Key; 4] = [
    direction("right"),
    direction("up"),
    direction("left"),
    direction("down"),
];
define_keys! {
    DIAGONAL: NumberKey = number("diagonal", Table::Binding, (0.0, 1.0, ""), 0.5, "width of the diagonals: 0 none, 0.5 as wide as the other directions, 1 everything");
}

/// A d-pad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dpad {
    /// Number of directions: 4 or 8.
    pub ways: u8,
    /// Nothing happens nearer to the centre; share of half of the region's shorter side.
    pub dead_zone: f64,
    /// Width of the diagonals: 0 none, 0.5 as wide as the other directions, 1 everything.
    pub diagonal: f64,
    /// Right, up, left, down.
    pub targets: [Option<Target>; 4],
}

impl GestureDefinition for Dpad {
    const KEYS: &'static [Key] = &[
        DIRECTIONS[0],
        DIRECTIONS[1],
        DIRECTIONS[2],
        DIRECTIONS[3],
        WAYS.key,
        DEAD_ZONE.key,
        DIAGONAL.key,
    ];
    const OUTPUT: Option<&'static str> = None;
    const TAKES_MODE: bool = false;
    const NEEDS_CENTRE: bool = true;
    const PLAYED_FROM: PlayedFrom = PlayedFrom::Sticks;

    fn read(binding: &mut BindingReader<'_>) -> Option<Self> {
        let targets = DIRECTIONS.map(|key| binding.target(&key));
        if !DIRECTIONS.iter().any(|key| binding.has(key.name)) {
            binding.mistake(
                "",
                "a dpad needs at least one of `up`, `down`, `left` and `right`",
                "this binding",
            );
        }
        Some(Self {
            ways: binding.ways_or(WAYS.default),
            dead_zone: binding.number(&DEAD_ZONE),
            diagonal: binding.number(&DIAGONAL),
            targets,
        })
    }

    fn describe(&self) -> String {
        format!("d-pad, {} ways", self.ways)
    }

    fn own_targets(&self) -> Vec<Target> {
        self.targets.iter().copied().flatten().collect()
    }
}
