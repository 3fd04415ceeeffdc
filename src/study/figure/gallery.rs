//! A table of pictures, each with its figures beneath.

use plotters::style::RGBColor;

use super::{Figure, Mark, both, text};
use crate::study::{Raster, StudyError};

/// A picture of a table of rasters, each with lines of text beneath.
#[derive(Clone, Debug)]
pub struct Gallery {
    /// File name without ending.
    pub name: String,
    /// Its title.
    pub title: String,
    /// Names of the rows.
    pub rows: Vec<String>,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Row by row: the raster, scaled to its peak, and what is said of it.
    pub cells: Vec<(Raster, Vec<String>)>,
}

fn shade(value: f64) -> RGBColor {
    let [r, g, b] = crate::types::heat(value as f32);
    RGBColor(r, g, b)
}

impl Gallery {
    /// Draws it.
    ///
    /// # Errors
    /// The drawing library's.
    pub fn draw(&self) -> Result<Figure, StudyError> {
        const CELL: i32 = 180;
        const GAP: i32 = 16;
        const LINE: i32 = 17;
        let said = self
            .cells
            .iter()
            .map(|(_, lines)| lines.len())
            .max()
            .unwrap_or(0) as i32;
        let pitch = (CELL + GAP, CELL + said * LINE + 2 * GAP);
        let (left, top) = (96, 76);
        let size = (
            (left + pitch.0 * self.columns.len() as i32 + 110) as u32,
            (top + pitch.1 * self.rows.len() as i32) as u32,
        );
        both(&self.name, &self.title, size, |put| {
            put(text((left, 22), &self.title, 19.0, -1));
            for (column, name) in self.columns.iter().enumerate() {
                put(text(
                    (left + column as i32 * pitch.0 + CELL / 2, 56),
                    name,
                    16.0,
                    0,
                ));
            }
            for (row, name) in self.rows.iter().enumerate() {
                put(text(
                    (left - 12, top + row as i32 * pitch.1 + CELL / 2),
                    name,
                    16.0,
                    1,
                ));
            }
            for (index, (raster, lines)) in self.cells.iter().enumerate() {
                let (row, column) = (index / self.columns.len(), index % self.columns.len());
                let corner = (left + column as i32 * pitch.0, top + row as i32 * pitch.1);
                picture(raster, corner, CELL, put);
                for (line, said) in lines.iter().enumerate() {
                    let y = corner.1 + CELL + 12 + line as i32 * LINE;
                    put(text((corner.0, y), said, 13.0, -1));
                }
            }
            let bar = left + pitch.0 * self.columns.len() as i32 + 6;
            for step in 0..CELL {
                put(Mark::Box {
                    corners: [(bar, top + step), (bar + 16, top + step + 1)],
                    colour: shade(1.0 - f64::from(step) / f64::from(CELL)),
                });
            }
            for (share, name) in [(0.0, "1"), (0.5, "0.5"), (1.0, "0")] {
                let y = top + (share * f64::from(CELL)) as i32;
                put(text((bar + 22, y), name, 13.0, -1));
            }
            put(text((bar, top + CELL + 16), "of the peak", 13.0, -1));
            Ok(())
        })
    }
}

fn picture(raster: &Raster, (x0, y0): (i32, i32), edge: i32, put: &mut dyn FnMut(Mark)) {
    let peak = raster.peak().max(f64::MIN_POSITIVE);
    let (columns, rows) = (raster.grid.columns, raster.grid.rows);
    let most = columns.max(rows) as f64;
    let at = |cell: usize| (cell as f64 / most * f64::from(edge)) as i32;
    for row in 0..rows {
        for column in 0..columns {
            let value = raster.values[row * columns + column] / peak;
            let (top, left) = (at(rows - 1 - row), at(column));
            put(Mark::Box {
                corners: [
                    (x0 + left, y0 + top),
                    (x0 + at(column + 1), y0 + at(rows - row)),
                ],
                colour: shade(value),
            });
        }
    }
}
