//! Pads and regions drawn with characters, for the live view and the `show` commands.

use crate::pad::Pad;
use crate::profile::Profile;
use crate::types::PointMm;

/// A grid of characters over a pad; row 0 is the top.
pub(super) struct Map {
    columns: usize,
    rows: usize,
    size_mm: [f64; 2],
    cells: Vec<char>,
}

impl Map {
    /// An empty map of a pad, `columns` characters wide; characters are twice as high as wide.
    pub(super) fn new(size_mm: [f64; 2], columns: usize) -> Self {
        let rows = (columns as f64 / 2.0 * size_mm[1] / size_mm[0])
            .round()
            .max(1.0) as usize;
        Self {
            columns,
            rows,
            size_mm,
            cells: vec![' '; columns * rows],
        }
    }

    /// The centre of a cell on the pad.
    fn centre_mm(&self, row: usize, column: usize) -> PointMm {
        [
            (column as f64 + 0.5) / self.columns as f64 * self.size_mm[0],
            (1.0 - (row as f64 + 0.5) / self.rows as f64) * self.size_mm[1],
        ]
    }

    /// Row and column of a place on the pad, limited to the map.
    fn cell_at(&self, [x, y]: PointMm) -> (usize, usize) {
        let column = x / self.size_mm[0] * self.columns as f64;
        let row = (1.0 - y / self.size_mm[1]) * self.rows as f64;
        (
            (row.max(0.0) as usize).min(self.rows - 1),
            (column.max(0.0) as usize).min(self.columns - 1),
        )
    }

    /// Draws the edges of a profile's regions and their names.
    pub(super) fn with_regions(mut self, profile: &Profile) -> Self {
        let region = |map: &Self, row: usize, column: usize| {
            profile.region_at(map.centre_mm(row, column), map.size_mm)
        };
        for row in 0..self.rows {
            for column in 0..self.columns {
                let here = region(&self, row, column);
                let edge = here.is_some()
                    && (row == 0
                        || column == 0
                        || row + 1 == self.rows
                        || column + 1 == self.columns
                        || region(&self, row - 1, column) != here
                        || region(&self, row + 1, column) != here
                        || region(&self, row, column - 1) != here
                        || region(&self, row, column + 1) != here);
                if edge {
                    self.cells[row * self.columns + column] = '·';
                }
            }
        }
        for region in &profile.regions {
            let (row, column) = self.cell_at(
                region
                    .placed(self.size_mm, &profile.settings.area)
                    .centre_mm(),
            );
            let start = column.saturating_sub(region.name.chars().count() / 2);
            self.write(row, start, &region.name);
        }
        self
    }

    /// Draws a pad's conductor and its electrodes, numbered from 1.
    pub(super) fn with_pad(mut self, pad: &Pad) -> Self {
        for row in 0..self.rows {
            for column in 0..self.columns {
                // A channel can be thinner than a character: several places in it are tested.
                let [x, y] = self.centre_mm(row, column);
                let step = self.size_mm[0] / self.columns as f64;
                let conducts = (-2..=2).any(|i| {
                    (-2..=2).any(|j| {
                        let point = [x + f64::from(i) * step / 5.0, y + f64::from(j) * step / 5.0];
                        pad.conducts_at(point)
                    })
                });
                if conducts {
                    self.cells[row * self.columns + column] = '░';
                }
            }
        }
        for (number, electrode) in (1..).zip(&pad.electrodes) {
            let (row, column) = self.cell_at(electrode.centre_mm(&pad.outline));
            let start = column.min(self.columns - 2);
            self.write(row, start, &format!("{number}"));
        }
        self
    }

    /// Draws a mark at a place.
    pub(super) fn with_mark(mut self, place_mm: PointMm, mark: char) -> Self {
        let (row, column) = self.cell_at(place_mm);
        self.cells[row * self.columns + column] = mark;
        self
    }

    fn write(&mut self, row: usize, column: usize, text: &str) {
        for (offset, character) in text.chars().enumerate() {
            if column + offset < self.columns {
                self.cells[row * self.columns + column + offset] = character;
            }
        }
    }

    /// All rows, top first, in a frame.
    pub(super) fn framed(&self) -> String {
        let bar = "─".repeat(self.columns);
        let mut text = format!("┌{bar}┐\n");
        for row in self.cells.chunks(self.columns) {
            text.push('│');
            text.extend(row);
            text.push_str("│\n");
        }
        text.push_str(&format!("└{bar}┘"));
        text
    }

    /// The character of a cell.
    pub(super) fn get(&self, row: usize, column: usize) -> char {
        self.cells[row * self.columns + column]
    }

    /// Number of rows.
    pub(super) fn rows(&self) -> usize {
        self.rows
    }
}
