//! The distance of a touch from a centre, as two axes.

use super::definition::{BindingReader, GestureDefinition, PlayedFrom};
use super::shared_keys::{CURVE, Curve, DEAD_ZONE, GAIN};
use crate::profile::keys::{Key, KeyKind, Table, WordKey, define_keys, word};
use crate::profile::target::Target;
use crate::types::Axis;

define_keys! {
    FLOATING: WordKey<bool> = word("stick", Table::Binding, &["fixed", "floating"], &[false, true], "floating: the centre is where the touch goes down");
    AXIS_X: Key = Key::new("axis_x", Table::Binding, KeyKind::Text, "pad:left-x or another axis, right is positive");
    AXIS_Y: Key = Key::new("axis_y", Table::Binding, KeyKind::Text, "pad:left-y or another axis, up is positive");
    DEAD_ZONE_SHAPE: WordKey<DeadZone> = word("dead_zone_shape", Table::Binding, &["round", "square"], &[DeadZone::Round, DeadZone::Square], "around the centre, or for each axis separately");
}
const fn gain(name: &'static str, about: &'static str) -> Key {
    Key::new(name, Table::Binding, GAIN.key.kind, about).or("gain")
}
const GAIN_RIGHT: Key = gain("gain_right", "factor to the right");
const GAIN_UP: Key = gain("gain_up", "factor up");
const GAIN_LEFT: Key = gain("gain_left", "factor to the left");
const GAIN_DOWN: Key = gain("gain_down", "factor down");

/// The shape of a stick's dead zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeadZone {
    /// A circle around the centre.
    Round,
    /// Each axis separately.
    Square,
}

/// Gain by direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// To the right.
    pub right: f64,
    /// Up.
    pub up: f64,
    /// To the left.
    pub left: f64,
    /// Down.
    pub down: f64,
}

/// A stick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stick {
    /// Whether its centre is where the touch goes down; else it is the region's.
    pub floating: bool,
    /// The shape of its dead zone.
    pub dead_zone: DeadZone,
    /// Its response.
    pub curve: Curve,
    /// Gain by direction.
    pub gains: Gains,
    /// The axis whose positive direction is right.
    pub x: Option<Axis>,
    /// The axis whose positive direction is up.
    pub y: Option<Axis>,
}

impl GestureDefinition for Stick {
    const KEYS: &'static [Key] = &[
        FLOATING.key,
        AXIS_X,
        AXIS_Y,
        DEAD_ZONE.key,
        DEAD_ZONE_SHAPE.key,
        CURVE.key,
        GAIN.key,
        GAIN_RIGHT,
        GAIN_UP,
        GAIN_LEFT,
        GAIN_DOWN,
    ];
    const OUTPUT: Option<&'static str> = None;
    const TAKES_MODE: bool = false;
    const NEEDS_CENTRE: bool = true;
    const PLAYED_FROM: PlayedFrom = PlayedFrom::Sticks;

    fn read(binding: &mut BindingReader<'_>) -> Option<Self> {
        let gain = binding.number(&GAIN);
        let [right, up, left, down] = [GAIN_RIGHT, GAIN_UP, GAIN_LEFT, GAIN_DOWN]
            .map(|key| binding.own_number(&key).unwrap_or(gain));
        if !binding.has("axis_x") && !binding.has("axis_y") {
            binding.mistake_with_help(
                "",
                "a stick needs `axis_x` or `axis_y`",
                "this binding",
                "write `axis_x = \"pad:left-x\"` and `axis_y = \"pad:left-y\"`",
            );
        }
        let floating = binding.choice(&FLOATING);
        if floating && binding.has("from") {
            binding.mistake(
                "stick",
                "the stick of a gamepad cannot be floating: its centre is fixed",
                "remove this",
            );
        }
        Some(Self {
            floating,
            dead_zone: binding.choice(&DEAD_ZONE_SHAPE),
            curve: binding.curve(),
            gains: Gains {
                right,
                up,
                left,
                down,
            },
            x: binding.axis(&AXIS_X),
            y: binding.axis(&AXIS_Y),
        })
    }

    fn describe(&self) -> String {
        let floating = if self.floating { "floating " } else { "" };
        format!("{floating}stick")
    }

    fn output_names(&self, _name_of: &dyn Fn(Target) -> String) -> Vec<String> {
        let axes = [self.x, self.y].into_iter().flatten();
        axes.map(|axis| format!("pad:{axis}")).collect()
    }
}
