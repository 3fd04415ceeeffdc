//! Regions: their order, and how they take touches.

use std::collections::BTreeSet;

use crate::profile::entries::{Entries, Place};
use crate::profile::keys::{
    FlagKey, Key, KeyKind, NumberKey, SHARE, SIZE, Table, WordKey, define_keys, flag, number, word,
};
use crate::profile::reader::Reader;
use crate::profile::{Region, Slide};

const fn key(name: &'static str, kind: KeyKind, about: &'static str) -> Key {
    Key::new(name, Table::Region, kind, about)
}
const fn share(name: &'static str, about: &'static str) -> Key {
    key(name, KeyKind::Number(SHARE.0, SHARE.1, SHARE.2), about)
}
const fn size(name: &'static str, about: &'static str) -> Key {
    key(name, KeyKind::Number(SIZE.0, SIZE.1, SIZE.2), about)
}
define_keys! {
    pub(super) SHAPE: Key = key("shape", KeyKind::Word(&["rect", "circle", "ellipse", "polygon", "grid"]), "its outline").or("rect");
    REACH: NumberKey = number("reach", Table::Region, SHARE, 0.0, "takes touches this far outside too");
    HELD_REACH: Key = share("held_reach", "keeps a touch that holds it this far outside, and lets go beyond").or("as reach");
    EXCLUSIVE: FlagKey = flag("exclusive", Table::Region, true, "a touch in it does not count for regions below");
    ORDER: NumberKey = number("order", Table::Region, (-1000.0, 1000.0, ""), 0.0, "higher is on top; equal ones in the order of the text, the first on top");
    SLIDE: WordKey<Slide> = word("slide", Table::Region, &["keep", "leave", "across"], &[Slide::Keep, Slide::Leave, Slide::Across], "a touch that moves out keeps the region, lets go, or presses where it arrives");
    FOOTPRINT: NumberKey = number("footprint", Table::Region, (0.0, 2.0, "of the footprint's radius"), 0.0, "a touch counts here too when this much of its footprint reaches the region");
    REST: FlagKey = flag("rest", Table::Region, false, "ignores touches that begin here: a place to rest a hand");
    pub(super) OFF: FlagKey = flag("off", Table::Region, false, "removes a region of the base");
}
const PLACED: &[&str] = &["rect", "circle", "ellipse", "grid"];
const SIZED: &[&str] = &["rect", "ellipse", "grid"];
define_keys! {
    pub(super) X: Key = share("x", "left edge (rect, grid) or centre (circle, ellipse)").only(PLACED);
    pub(super) Y: Key = share("y", "lower edge or centre").only(PLACED);
    pub(super) W: Key = size("w", "width").only(SIZED);
    pub(super) H: Key = size("h", "height").only(SIZED);
    pub(super) R: Key = size("r", "radius, relative to the pad's shorter side").only(&["circle"]);
    pub(super) POINTS: Key = key("points", KeyKind::Points, "corners, [[x, y], ...]").only(&["polygon"]);
    pub(super) COLUMNS: Key = key("columns", KeyKind::Count(1, 16), "cells in a row; cells are named NAME-1, NAME-2, ... from the top left, row by row").only(&["grid"]);
    pub(super) ROWS: Key = key("rows", KeyKind::Count(1, 16), "rows of cells").only(&["grid"]);
}
pub(in crate::profile) const KEYS: &[Key] = &[
    key("name", KeyKind::Text, "its name, for bindings"),
    SHAPE,
    X,
    Y,
    W,
    H,
    R,
    POINTS,
    COLUMNS,
    ROWS,
    REACH.key,
    HELD_REACH,
    EXCLUSIVE.key,
    ORDER.key,
    SLIDE.key,
    FOOTPRINT.key,
    REST.key,
    OFF.key,
];

/// Most regions of a profile.
const MOST_REGIONS: usize = 10_000;

impl Reader {
    /// All regions, topmost first.
    pub(super) fn regions(&mut self, tables: &[Entries]) -> Vec<Region> {
        let mut ordered: Vec<(f64, Region)> = Vec::new();
        let mut names: BTreeSet<String> = BTreeSet::new();
        for entries in tables {
            if self.flag(entries, &OFF) {
                continue;
            }
            let Some((name, place)) = self.region_name(entries) else {
                continue;
            };
            let order = self.number_or_default(entries, &ORDER);
            for region in self.region(entries, &name, &place) {
                if !names.insert(region.name.clone()) {
                    let message = format!("two regions are named `{}`", region.name);
                    self.errors.push(&place, message, "the second one");
                }
                ordered.push((order, region));
            }
            if ordered.len() > MOST_REGIONS {
                self.errors.help(
                    &place,
                    format!("more than {MOST_REGIONS} regions, the cells of grids included"),
                    "one too many",
                    "the pad cannot separate so many: use larger ones",
                );
                break;
            }
        }
        // Stable: equal ones stay in the order of the text.
        ordered.sort_by(|a, b| b.0.total_cmp(&a.0));
        ordered.into_iter().map(|(_, region)| region).collect()
    }

    fn region_name(&mut self, entries: &Entries) -> Option<(String, Place)> {
        if !entries.has("name") {
            self.errors.help(
                &entries.place,
                "the region has no `name`",
                "this region",
                "add `name = \"jump\"`",
            );
        }
        let (name, place) = self.text(entries, "name")?;
        if name.is_empty() {
            self.errors
                .push(&place, "the name of a region must not be empty", "empty");
        }
        Some((name, place))
    }

    /// One region, or the cells of a grid.
    fn region(&mut self, entries: &Entries, name: &str, place: &Place) -> Vec<Region> {
        let shape = self.word(entries, &SHAPE).unwrap_or("rect");
        let keys = KEYS.iter().map(|key| (key, key.only));
        self.refuse_foreign(entries, keys, &[shape], &format!("a {shape}"));
        let reach = self.number_or_default(entries, &REACH);
        let held = self.number(entries, &HELD_REACH);
        let slide = match self.choice(entries, &SLIDE) {
            // A limit for a touch that strays means that it lets go beyond.
            None if held.is_some() => Slide::Leave,
            slide => slide.unwrap_or(SLIDE.values[0]),
        };
        let exclusive = self.flag(entries, &EXCLUSIVE);
        let footprint = self.number_or_default(entries, &FOOTPRINT);
        let rest = self.flag(entries, &REST);
        let is_cell = shape == "grid";
        self.shapes(entries, shape, name, place)
            .into_iter()
            .map(|(name, shape)| Region {
                name,
                shape,
                reach,
                held_reach: held.unwrap_or(reach).max(reach),
                exclusive,
                slide,
                footprint,
                rest,
                is_cell,
            })
            .collect()
    }
}
