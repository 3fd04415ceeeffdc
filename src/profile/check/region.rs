//! Regions: shapes on the pad, their order, and what `grid` stands for.

use std::collections::BTreeMap;

use super::Check;
use crate::profile::keys::{self, Table};
use crate::profile::text::{Data, Entries, Place};
use crate::profile::{Region, Shape, Slide};

const PLACES: &str = "places are shares of the pad: 0 is left or bottom, 1 is right or top";
/// Two rows of a grid meet, as its columns do; a number that was rounded to the third place reaches no further.
const ROUNDING: f64 = 1e-9;

impl Check {
    /// All regions, topmost first.
    pub(super) fn regions(&mut self, tables: &[Entries]) -> Vec<Region> {
        let mut ordered: Vec<(f64, Region)> = Vec::new();
        let mut seen: BTreeMap<String, ()> = BTreeMap::new();
        for entries in tables {
            if self.flag(entries, "off") == Some(true) {
                continue;
            }
            let Some((name, place)) = self.text(entries, "name") else {
                if !entries.values.contains_key("name") {
                    self.faults.help(
                        &entries.place,
                        "the region has no `name`",
                        "this region",
                        "write `name = \"jump\"` in it",
                    );
                }
                continue;
            };
            if name.is_empty() {
                self.faults
                    .push(&place, "a region's name is not empty", "here");
            }
            let order = self.number(entries, "order", Table::Region).unwrap_or(0.0);
            for region in self.region(entries, &name, &place) {
                if seen.insert(region.name.clone(), ()).is_some() {
                    self.faults.push(
                        &place,
                        format!("two regions are named `{}`", region.name),
                        "the second one",
                    );
                }
                ordered.push((order, region));
            }
        }
        // Stable: equals stay in the order of the text.
        ordered.sort_by(|a, b| b.0.total_cmp(&a.0));
        ordered.into_iter().map(|(_, region)| region).collect()
    }

    /// One region, or the cells of a grid.
    fn region(&mut self, entries: &Entries, name: &str, place: &Place) -> Vec<Region> {
        let shape = self
            .choice(entries, "shape", Table::Region)
            .unwrap_or("rect");
        self.refuse_foreign(entries, Table::Region, &[shape], &format!("a {shape}"));
        let reach = self.number(entries, "reach", Table::Region).unwrap_or(0.0);
        let held = self.number(entries, "held_reach", Table::Region);
        let slide = match self.choice(entries, "slide", Table::Region) {
            Some("leave") => Slide::Leave,
            Some("across") => Slide::Across,
            // Who says how far a touch may stray means that it lets go beyond.
            None if held.is_some() => Slide::Leave,
            _ => Slide::Keep,
        };
        let of_shape = |shape: Shape, name: String| Region {
            name,
            shape,
            reach,
            held_reach: held.unwrap_or(reach).max(reach),
            exclusive: true,
            slide,
            footprint: 0.0,
            rest: false,
        };
        let mut regions = match shape {
            "grid" => {
                let [x, y, w, h] = self.rect(entries, name, place);
                let columns = self.needed_count(entries, name, place, "columns");
                let rows = self.needed_count(entries, name, place, "rows");
                let (cell_w, cell_h) = (w / f64::from(columns), h / f64::from(rows));
                (0..rows * columns)
                    .map(|index| {
                        let (row, column) = (index / columns, index % columns);
                        let cell = Shape::Rect {
                            x: x + cell_w * f64::from(column),
                            y: y + cell_h * f64::from(rows - 1 - row),
                            w: cell_w,
                            h: cell_h,
                        };
                        of_shape(cell, format!("{name}-{}", index + 1))
                    })
                    .collect()
            }
            _ => vec![of_shape(
                self.shape(entries, shape, name, place),
                name.to_owned(),
            )],
        };
        let exclusive = self.flag(entries, "exclusive").unwrap_or(true);
        let footprint = self
            .number(entries, "footprint", Table::Region)
            .unwrap_or(0.0);
        let rest = self.flag(entries, "rest").unwrap_or(false);
        for region in &mut regions {
            region.exclusive = exclusive;
            region.footprint = footprint;
            region.rest = rest;
        }
        regions
    }

    fn shape(&mut self, entries: &Entries, shape: &str, name: &str, place: &Place) -> Shape {
        match shape {
            "circle" => {
                let [x, y, r] = ["x", "y", "r"].map(|key| self.needed(entries, name, place, key));
                self.stays(entries, "r", [x - r, x + r], "left or right");
                self.stays(entries, "r", [y - r, y + r], "top or bottom");
                Shape::Circle { x, y, r }
            }
            "ellipse" => {
                let [x, y, w, h] =
                    ["x", "y", "w", "h"].map(|key| self.needed(entries, name, place, key));
                self.stays(entries, "w", [x - w / 2.0, x + w / 2.0], "left or right");
                self.stays(entries, "h", [y - h / 2.0, y + h / 2.0], "top or bottom");
                Shape::Ellipse { x, y, w, h }
            }
            "polygon" => Shape::Polygon(self.corners(entries, name, place)),
            _ => {
                let [x, y, w, h] = self.rect(entries, name, place);
                Shape::Rect { x, y, w, h }
            }
        }
    }

    fn rect(&mut self, entries: &Entries, name: &str, place: &Place) -> [f64; 4] {
        let [x, y, w, h] = ["x", "y", "w", "h"].map(|key| self.needed(entries, name, place, key));
        self.stays(entries, "w", [x, x + w], "right");
        self.stays(entries, "h", [y, y + h], "top");
        [x, y, w, h]
    }

    /// A number that the shape cannot do without.
    fn needed(&mut self, entries: &Entries, name: &str, place: &Place, key: &str) -> f64 {
        if !entries.values.contains_key(key) {
            self.needs(place, name, key);
        }
        // The stand-in lies on the pad whatever else does: no second fault comes of it.
        self.number(entries, key, Table::Region).unwrap_or(1e-3)
    }

    fn needed_count(&mut self, entries: &Entries, name: &str, place: &Place, key: &str) -> u32 {
        if !entries.values.contains_key(key) {
            self.needs(place, name, key);
        }
        self.count(entries, key, Table::Region).unwrap_or(1)
    }

    fn needs(&mut self, place: &Place, name: &str, key: &str) {
        let about = keys::find(Table::Region, key).map_or("", |key| key.about);
        self.faults.help(
            place,
            format!("the region `{name}` needs `{key}`"),
            "this region",
            format!("`{key}`: {about}"),
        );
    }

    fn stays(&mut self, entries: &Entries, key: &str, [from, to]: [f64; 2], side: &str) {
        let end = if to > 1.0 + ROUNDING {
            to
        } else if from < -ROUNDING {
            from
        } else {
            return;
        };
        if let Some(value) = entries.values.get(key) {
            self.faults.help(
                &value.place,
                format!("the region ends at {end:.3}, off the pad on the {side}"),
                "reaches off the pad",
                PLACES,
            );
        }
    }

    fn corners(&mut self, entries: &Entries, name: &str, place: &Place) -> Vec<[f64; 2]> {
        let stand_in = vec![[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]];
        let Some(value) = entries.values.get("points") else {
            self.needs(place, name, "points");
            return stand_in;
        };
        let Data::List(list) = &value.data else {
            self.faults.push(
                &value.place,
                "`points` is a list of corners: [[0.1, 0.2], [0.3, 0.2], ...]",
                "here",
            );
            return stand_in;
        };
        let mut corners = Vec::new();
        for corner in list {
            let pair = match &corner.data {
                Data::List(pair) => pair.as_slice(),
                _ => &[],
            };
            let [Data::Number(x), Data::Number(y)] =
                pair.iter().map(|v| &v.data).collect::<Vec<_>>()[..]
            else {
                self.faults
                    .push(&corner.place, "a corner is two numbers: [0.1, 0.2]", "here");
                return stand_in;
            };
            if !(0.0..=1.0).contains(x) || !(0.0..=1.0).contains(y) {
                self.faults.help(
                    &corner.place,
                    format!("the corner [{x}, {y}] lies off the pad"),
                    "off the pad",
                    PLACES,
                );
            }
            corners.push([*x, *y]);
        }
        if corners.len() < 3 {
            self.faults.push(
                &value.place,
                "a polygon has three corners or more",
                "too few",
            );
            return stand_in;
        }
        corners
    }

    /// Keys that this shape, gesture or mode does not take.
    pub(super) fn refuse_foreign(
        &mut self,
        entries: &Entries,
        table: Table,
        is: &[&str],
        what: &str,
    ) {
        for (name, value) in &entries.values {
            let Some(key) = keys::find(table, name) else {
                continue;
            };
            if !key.only.is_empty() && !is.iter().any(|is| key.only.contains(is)) {
                self.faults.help(
                    &value.place,
                    format!("{what} has no `{name}`"),
                    "take this out",
                    format!("`{name}` is for {}: {}", key.only.join(", "), key.about),
                );
            }
        }
    }
}
