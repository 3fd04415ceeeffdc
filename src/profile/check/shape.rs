//! The outlines of regions.

use super::region::{COLUMNS, H, POINTS, R, ROWS, W, X, Y};
use crate::profile::Shape;
use crate::profile::entries::{Data, Entries, Place, Value};
use crate::profile::keys::Key;
use crate::profile::reader::Reader;

const PLACES: &str = "places are shares of the pad: 0 is left or bottom, 1 is right or top";
/// Tolerance for numbers that add up to the edge of the pad.
const ROUNDING: f64 = 1e-9;
/// Stands for a number that is missing: on the pad whatever the others are, so that it causes no second error.
const STAND_IN: f64 = 1e-3;
/// Stands for corners that are missing.
const STAND_IN_CORNERS: [[f64; 2]; 3] = [[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]];

impl Reader {
    /// The outline of a region with its name, or those of the cells of a grid.
    pub(super) fn shapes(
        &mut self,
        entries: &Entries,
        shape: &str,
        name: &str,
        place: &Place,
    ) -> Vec<(String, Shape)> {
        let mut number = |key: &Key| {
            self.check_present(entries, name, place, key);
            self.number(entries, key).unwrap_or(STAND_IN)
        };
        let shape = match shape {
            "circle" => {
                let [x, y, r] = [&X, &Y, &R].map(&mut number);
                self.check_on_pad(entries, "r", [x - r, x + r], "left or right");
                self.check_on_pad(entries, "r", [y - r, y + r], "top or bottom");
                Shape::Circle { x, y, r }
            }
            "ellipse" => {
                let [x, y, w, h] = [&X, &Y, &W, &H].map(&mut number);
                self.check_on_pad(entries, "w", [x - w / 2.0, x + w / 2.0], "left or right");
                self.check_on_pad(entries, "h", [y - h / 2.0, y + h / 2.0], "top or bottom");
                Shape::Ellipse { x, y, w, h }
            }
            "polygon" => {
                self.check_present(entries, name, place, &POINTS);
                let corners = entries.get("points").and_then(|value| self.corners(value));
                Shape::Polygon(corners.unwrap_or(STAND_IN_CORNERS.to_vec()))
            }
            _ => {
                let [x, y, w, h] = [&X, &Y, &W, &H].map(&mut number);
                self.check_on_pad(entries, "w", [x, x + w], "right");
                self.check_on_pad(entries, "h", [y, y + h], "top");
                if shape == "grid" {
                    let [columns, rows] = [&COLUMNS, &ROWS].map(|key| {
                        self.check_present(entries, name, place, key);
                        self.count(entries, key).unwrap_or(1)
                    });
                    return cells(name, [x, y, w, h], columns, rows);
                }
                Shape::Rect { x, y, w, h }
            }
        };
        vec![(name.to_owned(), shape)]
    }

    /// Reports a key that the shape needs and the region does not have.
    fn check_present(&mut self, entries: &Entries, name: &str, place: &Place, key: &Key) {
        if !entries.has(key.name) {
            self.errors.help(
                place,
                format!("the region `{name}` needs `{}`", key.name),
                "this region",
                format!("`{}`: {}", key.name, key.about),
            );
        }
    }

    fn check_on_pad(&mut self, entries: &Entries, key: &str, [from, to]: [f64; 2], side: &str) {
        let end = if to > 1.0 + ROUNDING {
            to
        } else if from < -ROUNDING {
            from
        } else {
            return;
        };
        if let Some(value) = entries.get(key) {
            self.errors.help(
                &value.place,
                format!("the region ends at {end:.3}, off the pad on the {side}"),
                "extends off the pad",
                PLACES,
            );
        }
    }

    fn corners(&mut self, value: &Value) -> Option<Vec<[f64; 2]>> {
        let Data::List(list) = &value.data else {
            self.errors.push(
                &value.place,
                "`points` must be a list of corners: [[0.1, 0.2], [0.3, 0.2], ...]",
                "not a list",
            );
            return None;
        };
        let mut corners = Vec::new();
        for corner in list {
            corners.push(self.corner(corner)?);
        }
        if corners.len() < 3 {
            self.errors.push(
                &value.place,
                "a polygon needs at least three corners",
                "too few",
            );
            return None;
        }
        Some(corners)
    }

    fn corner(&mut self, corner: &Value) -> Option<[f64; 2]> {
        let numbers = match &corner.data {
            Data::List(pair) => pair.iter().map(|value| &value.data).collect(),
            _ => Vec::new(),
        };
        let [Data::Number(x), Data::Number(y)] = numbers[..] else {
            let message = "a corner must be two numbers, such as [0.1, 0.2]";
            self.errors.push(&corner.place, message, "not a corner");
            return None;
        };
        if ![x, y].iter().all(|share| (0.0..=1.0).contains(*share)) {
            self.errors.help(
                &corner.place,
                format!("the corner [{x}, {y}] is off the pad"),
                "off the pad",
                PLACES,
            );
        }
        Some([*x, *y])
    }
}

/// The cells of a grid, from the top left, row by row.
fn cells(name: &str, [x, y, w, h]: [f64; 4], columns: u32, rows: u32) -> Vec<(String, Shape)> {
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
            (format!("{name}-{}", index + 1), cell)
        })
        .collect()
}
