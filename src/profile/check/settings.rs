//! Settings: times, accessibility, safety, and the orientation of the pad.

use super::modes::CLASSIFY;
use crate::profile::entries::Entries;
use crate::profile::keys::{
    CountKey, FORCE, FlagKey, Key, KeyKind, MM, MS, NumberKey, SHARE, SIZE, Table, WordKey, count,
    define_keys, flag, number, time_ms, word,
};
use crate::profile::reader::Reader;
use crate::profile::{Activate, Area, Assist, Mirror, Rotation, Settings};
use crate::types::nanos_from_ms;

use Table::{Setting, User};

define_keys! {
    /// Two frames of a game at 60 frames/s: a shorter press can fall between two polls.
    MIN_HOLD_MS: NumberKey = time_ms("min_hold_ms", 34.0, "shortest press: games that poll can miss a press shorter than two frames");
    MIN_GAP_MS: NumberKey = time_ms("min_gap_ms", 0.0, "shortest release before the same output is pressed again");
    MAX_HOLD_MS: Key = Key::new("max_hold_ms", Setting, KeyKind::Number(MS.0, MS.1, MS.2), "a longer press is released by force").or("off");
    SLOW_KEYS_MS: NumberKey = time_ms("slow_keys_ms", 0.0, "SlowKeys: a touch counts only after this time");
    BOUNCE_KEYS_MS: NumberKey = time_ms("bounce_keys_ms", 0.0, "BounceKeys: a new press sooner than this after the last accepted release is ignored");
    pub(super) STICKY_KEYS: FlagKey = flag("sticky_keys", Setting, false, "StickyKeys: shift, ctrl, alt and meta stay down until another press is over");
    DWELL_MS: NumberKey = time_ms("dwell_ms", 0.0, "a touch counts when it has stayed in one place this long");
    /// A fingertip slips less than this.
    DWELL_MM: NumberKey = number("dwell_mm", Setting, MM, 6.0, "size of one place for dwell_ms");
    TREMOR_MM: NumberKey = number("tremor_mm", Setting, MM, 0.0, "moves smaller than this are ignored; a finger that returns within it is the same touch");
    TREMOR_MS: NumberKey = time_ms("tremor_ms", 0.0, "a finger that returns sooner than this has not lifted");
    ACTIVATE: WordKey<Activate> = word("activate", Setting, &["down", "up"], &[Activate::Down, Activate::Up], "up: a touch acts when it lifts, unless it left its region");
    ASSIST: WordKey<Assist> = word("assist", Setting, &["off", "first", "last"], &[Assist::Off, Assist::First, Assist::Last], "touch assistance: only the first or the last place of a touch counts");
    REST_AREA_MM2: Key = Key::new("rest_area_mm2", Setting, KeyKind::Number(1.0, 1e6, "mm2"), "contacts larger than this, and contacts that meet them, are ignored").or("off");
    /// A hand has five fingers; games need four at once.
    PANIC_CONTACTS: CountKey = count("panic_contacts", Setting, (0, 20), 5, "this many contacts at once release everything and pause; 0 turns it off");
    MIRROR: WordKey<Mirror> = word("mirror", Setting, &["none", "horizontal", "vertical", "both"], &[Mirror::None, Mirror::Horizontal, Mirror::Vertical, Mirror::Both], "mirrors the pad");
    ROTATE: NumberKey = number("rotate", Setting, (0.0, 270.0, "degrees"), 0.0, "turns the pad to the left: 0, 90, 180 or 270");
}
const AREA: [NumberKey; 4] = [
    number(
        "area_x",
        Setting,
        SHARE,
        0.0,
        "left edge of the part of the pad in which the regions lie",
    ),
    number("area_y", Setting, SHARE, 0.0, "its lower edge"),
    number("area_w", Setting, SIZE, 1.0, "its width"),
    number("area_h", Setting, SIZE, 1.0, "its height"),
];
const FORCE_MIN: NumberKey = number("force_min", User, FORCE, 0.0, "force that counts as none");
const FORCE_MAX: NumberKey = number("force_max", User, FORCE, 1.0, "force that counts as full");
const REACH: [NumberKey; 4] = [
    number(
        "reach_x",
        User,
        SHARE,
        0.0,
        "left edge of the part of the pad that the person can reach",
    ),
    number("reach_y", User, SHARE, 0.0, "its lower edge"),
    number("reach_w", User, SIZE, 1.0, "its width"),
    number("reach_h", User, SIZE, 1.0, "its height"),
];

/// Keys of a profile and of user settings.
pub(in crate::profile) const KEYS: &[Key] = &[
    MIN_HOLD_MS.key,
    MIN_GAP_MS.key,
    MAX_HOLD_MS,
    CLASSIFY.key,
    SLOW_KEYS_MS.key,
    BOUNCE_KEYS_MS.key,
    STICKY_KEYS.key,
    DWELL_MS.key,
    DWELL_MM.key,
    TREMOR_MM.key,
    TREMOR_MS.key,
    ACTIVATE.key,
    ASSIST.key,
    REST_AREA_MM2,
    PANIC_CONTACTS.key,
    MIRROR.key,
    ROTATE.key,
    AREA[0].key,
    AREA[1].key,
    AREA[2].key,
    AREA[3].key,
];

/// Keys of user settings only.
pub(in crate::profile) const USER_KEYS: &[Key] = &[
    FORCE_MIN.key,
    FORCE_MAX.key,
    REACH[0].key,
    REACH[1].key,
    REACH[2].key,
    REACH[3].key,
];

impl Reader {
    pub(super) fn settings(&mut self, top: &Entries) -> Settings {
        let max_hold_ms = self.number(top, &MAX_HOLD_MS);
        let panic_contacts = self.count_or_default(top, &PANIC_CONTACTS) as usize;
        Settings {
            min_hold_ns: self.ms_or_default(top, &MIN_HOLD_MS),
            min_gap_ns: self.ms_or_default(top, &MIN_GAP_MS),
            max_hold_ns: max_hold_ms.map(nanos_from_ms).filter(|time| *time > 0),
            slow_keys_ns: self.ms_or_default(top, &SLOW_KEYS_MS),
            bounce_keys_ns: self.ms_or_default(top, &BOUNCE_KEYS_MS),
            dwell_ns: self.ms_or_default(top, &DWELL_MS),
            dwell_mm: self.number_or_default(top, &DWELL_MM),
            tremor_mm: self.number_or_default(top, &TREMOR_MM),
            tremor_ns: self.ms_or_default(top, &TREMOR_MS),
            activate: self.choice_or_default(top, &ACTIVATE),
            assist: self.choice_or_default(top, &ASSIST),
            rest_area_mm2: self.number(top, &REST_AREA_MM2),
            sticky_keys: self.flag(top, &STICKY_KEYS),
            panic_contacts: (panic_contacts > 0).then_some(panic_contacts),
            force_range: self.force_range(top),
            mirror: self.choice_or_default(top, &MIRROR),
            rotate: self.rotation(top),
            area: self.area(top, &AREA),
            reachable: Some(self.area(top, &REACH)).filter(|area| *area != Area::PAD),
        }
    }

    fn force_range(&mut self, top: &Entries) -> [f64; 2] {
        let range = [&FORCE_MIN, &FORCE_MAX].map(|key| self.number_or_default(top, key));
        let written = top.get("force_max").or_else(|| top.get("force_min"));
        if range[0] >= range[1]
            && let Some(value) = written
        {
            self.errors.push(
                &value.place,
                "`force_max` must be above `force_min`",
                "empty range",
            );
        }
        range
    }

    fn rotation(&mut self, top: &Entries) -> Rotation {
        let degrees = self.number_or_default(top, &ROTATE);
        let turns = [
            (0.0, Rotation::None),
            (90.0, Rotation::Quarter),
            (180.0, Rotation::Half),
            (270.0, Rotation::ThreeQuarters),
        ];
        let found = turns.into_iter().find(|(turned, _)| *turned == degrees);
        if found.is_none() {
            self.errors.push(
                top.place_of("rotate"),
                format!("`rotate` = {degrees} is not a quarter turn: write 0, 90, 180 or 270"),
                "not a quarter turn",
            );
        }
        found.map_or(Rotation::None, |(_, rotation)| rotation)
    }

    /// A rectangle from four keys; without a width or height it reaches to the edge of the pad.
    fn area(&mut self, top: &Entries, keys: &[NumberKey; 4]) -> Area {
        let [x, y] = [0, 1].map(|i| self.number_or_default(top, &keys[i]));
        let [w, h] = [(2, x), (3, y)].map(|(i, from)| {
            let own = self.number(top, &keys[i].key);
            own.unwrap_or(keys[i].default - from)
        });
        for (end, keys, side) in [
            (x + w, [&keys[2], &keys[0]], "right"),
            (y + h, [&keys[3], &keys[1]], "top"),
        ] {
            let written = keys.iter().find_map(|key| top.get(key.key.name));
            if end > 1.0 + 1e-9
                && let Some(value) = written
            {
                self.errors.push(
                    &value.place,
                    format!("this part of the pad ends at {end:.3}, off the pad on the {side}"),
                    "extends off the pad",
                );
            }
        }
        Area { x, y, w, h }
    }
}
