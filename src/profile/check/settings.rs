//! The settings: times, accessibility, safety, and how the pad lies.

use super::Check;
use crate::profile::keys::Table::User;
use crate::profile::text::Entries;
use crate::profile::{Activate, Area, Assist, Mirror, Rotation, Settings};
use crate::types::{Nanos, nanos_from_ms};

/// Two frames of a game at 60 frames/s: a shorter press can fall between two polls.
const MIN_HOLD_MS: f64 = 34.0;
/// What one place is for a dwelling touch: a fingertip's slip.
const DWELL_MM: f64 = 6.0;
/// A hand has five fingers; games need four at once.
const PANIC_CONTACTS: u32 = 5;

impl Check {
    pub(super) fn settings(&mut self, top: &Entries) -> Settings {
        let force_range = [
            self.number(top, "force_min", User).unwrap_or(0.0),
            self.number(top, "force_max", User).unwrap_or(1.0),
        ];
        if force_range[0] >= force_range[1]
            && let Some(value) = top
                .values
                .get("force_max")
                .or_else(|| top.values.get("force_min"))
        {
            self.faults.push(
                &value.place,
                "`force_max` must lie above `force_min`",
                "here",
            );
        }
        Settings {
            min_hold_ns: self.ms(top, "min_hold_ms", MIN_HOLD_MS),
            min_gap_ns: self.ms(top, "min_gap_ms", 0.0),
            max_hold_ns: self.time(top, "max_hold_ms", User).filter(|time| *time > 0),
            slow_keys_ns: self.ms(top, "slow_keys_ms", 0.0),
            bounce_keys_ns: self.ms(top, "bounce_keys_ms", 0.0),
            dwell_ns: self.ms(top, "dwell_ms", 0.0),
            dwell_mm: self.number(top, "dwell_mm", User).unwrap_or(DWELL_MM),
            tremor_mm: self.number(top, "tremor_mm", User).unwrap_or(0.0),
            tremor_ns: self.ms(top, "tremor_ms", 0.0),
            activate: match self.choice(top, "activate", User) {
                Some("up") => Activate::Up,
                _ => Activate::Down,
            },
            assist: match self.choice(top, "assist", User) {
                Some("first") => Assist::First,
                Some("last") => Assist::Last,
                _ => Assist::Off,
            },
            rest_area_mm2: self.number(top, "rest_area_mm2", User),
            panic_contacts: match self
                .count(top, "panic_contacts", User)
                .unwrap_or(PANIC_CONTACTS)
            {
                0 => None,
                count => Some(count as usize),
            },
            force_range,
            mirror: match self.choice(top, "mirror", User) {
                Some("horizontal") => Mirror::Horizontal,
                Some("vertical") => Mirror::Vertical,
                Some("both") => Mirror::Both,
                _ => Mirror::None,
            },
            rotate: self.rotation(top),
            area: self
                .area(top, ["area_x", "area_y", "area_w", "area_h"])
                .unwrap_or(Area::PAD),
            reachable: self.area(top, ["reach_x", "reach_y", "reach_w", "reach_h"]),
        }
    }

    fn ms(&mut self, top: &Entries, name: &str, default_ms: f64) -> Nanos {
        self.time(top, name, User)
            .unwrap_or_else(|| nanos_from_ms(default_ms))
    }

    fn rotation(&mut self, top: &Entries) -> Rotation {
        let Some(degrees) = self.number(top, "rotate", User) else {
            return Rotation::None;
        };
        for (turned, rotation) in [
            (0.0, Rotation::None),
            (90.0, Rotation::Quarter),
            (180.0, Rotation::Half),
            (270.0, Rotation::ThreeQuarters),
        ] {
            if degrees == turned {
                return rotation;
            }
        }
        if let Some(value) = top.values.get("rotate") {
            self.faults.push(
                &value.place,
                format!("`rotate` = {degrees} is no quarter turn: 0, 90, 180 or 270"),
                "here",
            );
        }
        Rotation::None
    }

    /// A rectangle by four keys, if any of them stands.
    fn area(&mut self, top: &Entries, names: [&str; 4]) -> Option<Area> {
        let [x, y, w, h] = names.map(|name| self.number(top, name, User));
        if [x, y, w, h].iter().all(Option::is_none) {
            return None;
        }
        let (x, y) = (x.unwrap_or(0.0), y.unwrap_or(0.0));
        let area = Area {
            x,
            y,
            w: w.unwrap_or(1.0 - x),
            h: h.unwrap_or(1.0 - y),
        };
        for (end, keys, side) in [
            (area.x + area.w, [names[2], names[0]], "right"),
            (area.y + area.h, [names[3], names[1]], "top"),
        ] {
            let written = keys.iter().find_map(|key| top.values.get(*key));
            if end > 1.0 + 1e-9
                && let Some(value) = written
            {
                self.faults.push(
                    &value.place,
                    format!("this part of the pad ends at {end:.3}, off the pad on the {side}"),
                    "reaches off the pad",
                );
            }
        }
        Some(area)
    }
}
