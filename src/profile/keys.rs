//! Every key that a profile may hold: its kind, its range, what it is for. The checker, the schema and the guide's
//! table read this one list, so that they cannot differ.

/// Longest time in a profile, ms.
const LONGEST_MS: f64 = 60_000.0;

/// Where a key stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// At the top of a profile.
    Profile,
    /// At the top of a profile and in a person's text.
    Setting,
    /// In a person's text alone.
    User,
    /// In `[[region]]`.
    Region,
    /// In `[[binding]]`.
    Binding,
    /// In `[match]`.
    Match,
}

/// What a key's value is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A number in a range, with its unit.
    Number(f64, f64, &'static str),
    /// A whole number in a range.
    Count(u32, u32),
    /// One of some words.
    Word(&'static [&'static str]),
    /// Any text.
    Text,
    /// A text or a list of texts.
    Texts,
    /// true or false.
    Flag,
    /// Pairs of numbers.
    Points,
}

/// A key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// Where it stands.
    pub table: Table,
    /// What its value is.
    pub kind: Kind,
    /// Shapes, gestures or modes that take it; empty for all.
    pub only: &'static [&'static str],
    /// What holds without it; empty if it must stand or nothing holds.
    pub default: &'static str,
    /// What it is for, a sentence without a full stop.
    pub about: &'static str,
}

/// Shapes of a region.
pub(super) const SHAPES: &[&str] = &["rect", "circle", "ellipse", "polygon", "grid"];
/// Gestures.
pub(super) const GESTURES: &[&str] = &[
    "press",
    "tap",
    "hold",
    "double-tap",
    "swipe",
    "chord",
    "contacts",
    "force",
    "dpad",
    "stick",
    "trigger",
    "pointer",
    "tap-hold",
];
/// Modes of driving.
pub(super) const MODES: &[&str] = &[
    "direct",
    "classified",
    "latch",
    "tap",
    "toggle",
    "turbo",
    "repeat",
    "sticky",
    "macro",
];
/// Directions, counter-clockwise from the right.
pub(super) const DIRECTIONS: &[&str] = &[
    "right",
    "up-right",
    "up",
    "up-left",
    "left",
    "down-left",
    "down",
    "down-right",
];
const FLAVOURS: &[&str] = &["speculative", "tap-preferred", "balanced", "hold-preferred"];
const METHODS: &[&str] = &["tikhonov", "noser", "smooth", "l1"];

const MS: Kind = Kind::Number(0.0, LONGEST_MS, "ms");
const SHARE: Kind = Kind::Number(0.0, 1.0, "of the pad");
const SIZE: Kind = Kind::Number(1e-3, 1.0, "of the pad");
const GAIN: Kind = Kind::Number(0.0, 100.0, "");
const FORCE: Kind = Kind::Number(0.0, 1.0, "of full force");
const MM: Kind = Kind::Number(0.0, 1000.0, "mm");
const FRAMES: Kind = Kind::Number(1.0, 600.0, "frames");

const fn key(
    name: &'static str,
    table: Table,
    kind: Kind,
    default: &'static str,
    about: &'static str,
) -> Key {
    Key {
        name,
        table,
        kind,
        only: &[],
        default,
        about,
    }
}

const fn only(only: &'static [&'static str], key: Key) -> Key {
    Key { only, ..key }
}

use Table::{Binding, Match, Profile, Region, Setting, User};

/// All of them, in the order in which the guide explains them.
#[rustfmt::skip]
const KEYS: &[Key] = &[
    key("schema", Profile, Kind::Count(1, 1), "", "version of the format"),
    key("name", Profile, Kind::Text, "", "the profile's name"),
    key("about", Profile, Kind::Text, "", "one sentence for lists"),
    key("extends", Profile, Kind::Text, "", "a shipped profile or a file whose keys hold where this text has none"),
    key("method", Profile, Kind::Word(METHODS), "the pad's", "how images are made"),

    key("min_hold_ms", Setting, MS, "34", "shortest press: games that poll miss shorter ones than two frames"),
    key("min_gap_ms", Setting, MS, "0", "shortest release before the same output is pressed again"),
    key("max_hold_ms", Setting, MS, "off", "a longer press is released by force"),
    key("long_ms", Setting, MS, "200", "parts a short press from a long one (mode classified)"),
    key("classify", Setting, Kind::Word(&["down", "decided"]), "down", "decided: mode classified presses when the length is known, a short press at the lift, a long one after long_ms; for whom a short press takes long"),
    key("short_frames", Setting, FRAMES, "5", "length of a short press, in frames of the NES"),
    key("long_frames", Setting, FRAMES, "32", "length of a long press, in frames of the NES"),
    key("tapping_term_ms", Setting, MS, "200", "a touch that lifts sooner is a tap"),
    key("quick_tap_ms", Setting, MS, "0", "a touch sooner than this after a tap is a tap at once, for as long as it lasts"),
    key("require_prior_idle_ms", Setting, MS, "0", "a touch sooner than this after any other press is a tap at once"),
    key("hold_ms", Setting, MS, "400", "a touch that stays this long is a hold (long press)"),
    key("double_tap_ms", Setting, MS, "300", "the second touch of a double tap comes sooner than this after the first"),
    key("chord_ms", Setting, MS, "60", "the touches of a chord come sooner than this after each other"),
    key("slop_mm", Setting, MM, "8", "a touch that moves this far is no tap and no hold"),
    key("swipe_mm", Setting, MM, "15", "a stroke this long is a swipe"),
    key("swipe_ms", Setting, MS, "300", "a swipe is done sooner than this"),
    key("tap_ms", Setting, MS, "34", "length of a press in mode tap and of `tap` in a macro"),
    key("slow_keys_ms", Setting, MS, "0", "SlowKeys: a touch counts only after this time"),
    key("bounce_keys_ms", Setting, MS, "0", "BounceKeys: a re-press sooner than this after the last accepted release is ignored"),
    key("sticky_keys", Setting, Kind::Flag, "false", "StickyKeys: shift, ctrl, alt and meta stay down until another press is over"),
    key("repeat_delay_ms", Setting, MS, "500", "RepeatKeys: from the first press to the second (mode repeat)"),
    key("repeat_ms", Setting, MS, "100", "RepeatKeys: from each further press to the next"),
    key("dwell_ms", Setting, MS, "0", "a touch counts when it has stayed in one place this long"),
    key("dwell_mm", Setting, MM, "6", "what one place is for dwell_ms"),
    key("tremor_mm", Setting, MM, "0", "moves smaller than this are not seen; a finger that comes back within it is the same touch"),
    key("tremor_ms", Setting, MS, "0", "a finger that comes back sooner than this has not lifted"),
    key("activate", Setting, Kind::Word(&["down", "up"]), "down", "up: a touch acts when it lifts, unless it left its region"),
    key("assist", Setting, Kind::Word(&["off", "first", "last"]), "off", "touch assistance: the first or the last place of a touch counts"),
    key("rest_area_mm2", Setting, Kind::Number(1.0, 1e6, "mm2"), "off", "a contact larger than this gives nothing, nor does what touches it"),
    key("panic_contacts", Setting, Kind::Count(0, 20), "5", "so many contacts at once release everything and pause; 0 switches it off"),
    key("mirror", Setting, Kind::Word(&["none", "horizontal", "vertical", "both"]), "none", "the pad in a mirror"),
    key("rotate", Setting, Kind::Number(0.0, 270.0, "degrees"), "0", "the pad turned to the left: 0, 90, 180 or 270"),
    key("area_x", Setting, SHARE, "0", "left edge of the part of the pad in which the regions lie"),
    key("area_y", Setting, SHARE, "0", "its lower edge"),
    key("area_w", Setting, SIZE, "1", "its width"),
    key("area_h", Setting, SIZE, "1", "its height"),

    key("force_min", User, FORCE, "0", "force that counts as none"),
    key("force_max", User, FORCE, "1", "force that counts as full"),
    key("reach_x", User, SHARE, "0", "left edge of what this person reaches"),
    key("reach_y", User, SHARE, "0", "its lower edge"),
    key("reach_w", User, SIZE, "1", "its width"),
    key("reach_h", User, SIZE, "1", "its height"),

    key("process", Match, Kind::Texts, "", "names of processes: while one runs, `play --match` plays this profile"),

    key("name", Region, Kind::Text, "", "what bindings call it"),
    key("shape", Region, Kind::Word(SHAPES), "rect", "its outline"),
    only(&["rect", "circle", "ellipse", "grid"], key("x", Region, SHARE, "", "left edge (rect, grid) or centre (circle, ellipse)")),
    only(&["rect", "circle", "ellipse", "grid"], key("y", Region, SHARE, "", "lower edge or centre")),
    only(&["rect", "ellipse", "grid"], key("w", Region, SIZE, "", "width")),
    only(&["rect", "ellipse", "grid"], key("h", Region, SIZE, "", "height")),
    only(&["circle"], key("r", Region, SIZE, "", "radius, of the pad's shorter side")),
    only(&["polygon"], key("points", Region, Kind::Points, "", "corners, [[x, y], ...]")),
    only(&["grid"], key("columns", Region, Kind::Count(1, 16), "", "cells in a row; cells are named NAME-1, NAME-2, ... as one reads")),
    only(&["grid"], key("rows", Region, Kind::Count(1, 16), "", "rows of cells")),
    key("reach", Region, SHARE, "0", "it takes touches this far outside too"),
    key("held_reach", Region, SHARE, "as reach", "a touch that holds it keeps it this far outside, and lets go beyond"),
    key("exclusive", Region, Kind::Flag, "true", "a touch in it counts for no region below"),
    key("order", Region, Kind::Number(-1000.0, 1000.0, ""), "0", "higher lies on top; equals in the order of the text, the first on top"),
    key("slide", Region, Kind::Word(&["keep", "leave", "across"]), "keep", "a touch that leaves keeps it, lets go, or presses where it arrives"),
    key("footprint", Region, Kind::Number(0.0, 2.0, "of the footprint's radius"), "0", "a touch counts here too when this much of its footprint reaches it"),
    key("rest", Region, Kind::Flag, "false", "touches that begin here give nothing"),
    key("off", Region, Kind::Flag, "false", "takes a base's region out"),

    key("region", Binding, Kind::Texts, "the pad", "the region, or several"),
    key("from", Binding, Kind::Texts, "", "a gamepad's or switch's pad:a, pad:left-trigger, stick:left, ..., or several: beside the region, or instead of one"),
    key("layer", Binding, Kind::Text, "always", "counts only while this layer is on"),
    key("gesture", Binding, Kind::Word(GESTURES), "press", "what the touch must be"),
    key("mode", Binding, Kind::Word(MODES), "direct", "how the output is driven"),
    key("output", Binding, Kind::Texts, "", "key:NAME, pad:NAME, mouse:NAME, layer:NAME, gelpad:pause; or several"),
    only(&["dpad"], key("right", Binding, Kind::Text, "", "output of this direction")),
    only(&["dpad"], key("up", Binding, Kind::Text, "", "output of this direction")),
    only(&["dpad"], key("left", Binding, Kind::Text, "", "output of this direction")),
    only(&["dpad"], key("down", Binding, Kind::Text, "", "output of this direction")),
    only(&["swipe"], key("direction", Binding, Kind::Word(DIRECTIONS), "", "where the stroke goes")),
    only(&["swipe", "dpad"], key("ways", Binding, Kind::Count(4, 8), "4", "directions that are told apart: 4 or 8")),
    only(&["swipe", "contacts"], key("fingers", Binding, Kind::Count(1, 10), "1", "touches that move or lie together")),
    only(&["swipe"], key("swipe_mm", Binding, MM, "15", "a stroke this long is a swipe")),
    only(&["swipe"], key("swipe_ms", Binding, MS, "300", "a swipe is done sooner than this")),
    only(&["tap", "hold"], key("slop_mm", Binding, MM, "8", "a touch that moves this far is no tap and no hold")),
    only(&["tap", "double-tap", "tap-hold"], key("tapping_term_ms", Binding, MS, "200", "a touch that lifts sooner is a tap")),
    only(&["double-tap"], key("double_tap_ms", Binding, MS, "300", "the second touch comes sooner than this after the first")),
    only(&["hold"], key("hold_ms", Binding, MS, "400", "a touch that stays this long is a hold")),
    only(&["chord"], key("chord_ms", Binding, MS, "60", "the touches come sooner than this after each other")),
    only(&["tap-hold"], key("tap", Binding, Kind::Texts, "", "output of a tap")),
    only(&["tap-hold"], key("hold", Binding, Kind::Texts, "", "output of a hold")),
    only(&["tap-hold"], key("flavour", Binding, Kind::Word(FLAVOURS), "speculative", "who decides between tap and hold")),
    only(&["tap-hold"], key("quick_tap_ms", Binding, MS, "0", "a touch sooner than this after a tap is a tap at once")),
    only(&["tap-hold"], key("require_prior_idle_ms", Binding, MS, "0", "a touch sooner than this after any other press is a tap at once")),
    only(&["force"], key("force", Binding, FORCE, "0.5", "goes down at this force")),
    only(&["force"], key("force_release", Binding, FORCE, "0.8 of force", "comes up below this force")),
    only(&["stick"], key("stick", Binding, Kind::Word(&["fixed", "floating"]), "fixed", "floating: the middle is where the touch goes down")),
    only(&["stick"], key("axis_x", Binding, Kind::Text, "", "pad:left-x or another axis, right positive")),
    only(&["stick"], key("axis_y", Binding, Kind::Text, "", "pad:left-y or another axis, up positive")),
    only(&["trigger"], key("axis", Binding, Kind::Text, "", "pad:right-trigger or another axis")),
    only(&["dpad", "stick", "trigger"], key("dead_zone", Binding, Kind::Number(0.0, 0.95, "of the way"), "0.2", "nothing nearer to the middle")),
    only(&["stick"], key("dead_zone_shape", Binding, Kind::Word(&["round", "square"]), "round", "around the middle, or each axis for itself")),
    only(&["dpad"], key("diagonal", Binding, Kind::Number(0.0, 1.0, ""), "0.5", "how wide diagonals are")),
    only(&["stick", "trigger"], key("curve", Binding, Kind::Number(0.1, 10.0, ""), "1", "exponent of the answer: 2 is finer near the middle")),
    only(&["stick", "trigger", "pointer"], key("gain", Binding, GAIN, "1", "factor; pixels or notches a millimetre for a pointer")),
    only(&["stick"], key("gain_right", Binding, GAIN, "gain", "factor to the right")),
    only(&["stick"], key("gain_up", Binding, GAIN, "gain", "factor up")),
    only(&["stick"], key("gain_left", Binding, GAIN, "gain", "factor to the left")),
    only(&["stick"], key("gain_down", Binding, GAIN, "gain", "factor down")),
    only(&["pointer"], key("pointer", Binding, Kind::Word(&["motion", "wheel"]), "motion", "what a moving touch does")),
    only(&["latch"], key("length_ms", Binding, MS, "100", "length of the press")),
    only(&["classified"], key("long_ms", Binding, MS, "200", "parts a short press from a long one")),
    only(&["classified"], key("short_frames", Binding, FRAMES, "5", "length of a short press, in frames of the NES")),
    only(&["classified"], key("long_frames", Binding, FRAMES, "32", "length of a long press, in frames of the NES")),
    only(&["tap", "macro"], key("tap_ms", Binding, MS, "34", "length of the press")),
    only(&["turbo"], key("turbo_hz", Binding, Kind::Number(0.1, 30.0, "Hz"), "8", "presses a second")),
    only(&["repeat"], key("repeat_delay_ms", Binding, MS, "500", "from the first press to the second")),
    only(&["repeat"], key("repeat_ms", Binding, MS, "100", "from each further press to the next")),
    only(&["macro"], key("macro", Binding, Kind::Texts, "", "`press X`, `release X`, `tap X`, `wait MS`")),
    key("off", Binding, Kind::Flag, "false", "takes a base's binding out"),
];

/// Words that people write for a key.
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

/// Every key, in the order in which the guide explains them.
#[must_use]
pub fn keys() -> &'static [Key] {
    KEYS
}

/// Whether a key of one table may stand in a text's table.
fn stands(own: Table, table: Table) -> bool {
    own == table || (own == Setting && matches!(table, Profile | User))
}

/// The keys that may stand in a table.
pub(super) fn of(table: Table) -> impl Iterator<Item = &'static Key> {
    KEYS.iter().filter(move |key| stands(key.table, table))
}

/// A key by name.
pub(super) fn find(table: Table, name: &str) -> Option<&'static Key> {
    of(table).find(|key| key.name == name)
}
