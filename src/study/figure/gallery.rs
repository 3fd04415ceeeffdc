//! A table of images, each with its figures of merit underneath.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::{Area, Drawn, FONT, Figure, Picture, render};
use crate::study::{Raster, StudyError};

/// Edge of an image, gap between images, height of a line of text, pixels.
const CELL: i32 = 180;
const GAP: i32 = 16;
const LINE: i32 = 17;
/// Room for the names of the rows, and for the title and the names of the columns, pixels.
const CORNER: (i32, i32) = (96, 76);

/// A table of rasters, each with lines of text underneath.
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
    /// Row by row: the raster, shown in units of its peak, and the lines of text.
    pub cells: Vec<(Raster, Vec<String>)>,
}

impl Gallery {
    /// Renders the gallery.
    ///
    /// # Errors
    /// An error of the drawing library.
    pub fn draw(&self) -> Result<Figure, StudyError> {
        let (right, bottom) = self.corner(self.columns.len(), self.rows.len());
        let size = ((right + 110) as u32, bottom as u32);
        render(&self.name, &self.title, size, self)
    }

    /// Top-left pixel of a cell.
    fn corner(&self, column: usize, row: usize) -> (i32, i32) {
        let lines = self.cells.iter().map(|(_, lines)| lines.len()).max();
        let height = CELL + lines.unwrap_or(0) as i32 * LINE + 2 * GAP;
        let (left, top) = CORNER;
        (
            left + column as i32 * (CELL + GAP),
            top + row as i32 * height,
        )
    }
}

impl Picture for Gallery {
    fn draw_on<B: DrawingBackend>(&self, area: &Area<B>) -> Drawn<B> {
        label(area, (CORNER.0, 22), &self.title, 19, HPos::Left)?;
        for (column, name) in self.columns.iter().enumerate() {
            let (left, top) = self.corner(column, 0);
            label(area, (left + CELL / 2, top - 20), name, 16, HPos::Center)?;
        }
        for (row, name) in self.rows.iter().enumerate() {
            let (left, top) = self.corner(0, row);
            label(area, (left - 12, top + CELL / 2), name, 16, HPos::Right)?;
        }
        for (index, (raster, lines)) in self.cells.iter().enumerate() {
            let (left, top) = self.corner(index % self.columns.len(), index / self.columns.len());
            image(raster, &area.clone().shrink((left, top), (CELL, CELL)))?;
            for (line, text) in lines.iter().enumerate() {
                let y = top + CELL + 12 + line as i32 * LINE;
                label(area, (left, y), text, 13, HPos::Left)?;
            }
        }
        let (left, top) = self.corner(self.columns.len(), 0);
        colour_bar(area, left + 6, top)
    }
}

/// An image in units of its peak.
fn image<B: DrawingBackend>(raster: &Raster, area: &Area<B>) -> Drawn<B> {
    let peak = raster.peak().max(f64::MIN_POSITIVE);
    let columns = raster.grid.columns;
    let edge = columns.max(raster.grid.rows) as i32;
    let mut chart = ChartBuilder::on(area).build_cartesian_2d(0..edge, 0..edge)?;
    chart.draw_series(raster.values.iter().enumerate().map(|(cell, value)| {
        let (x, y) = ((cell % columns) as i32, (cell / columns) as i32);
        Rectangle::new([(x, y), (x + 1, y + 1)], shade(value / peak).filled())
    }))?;
    Ok(())
}

fn colour_bar<B: DrawingBackend>(area: &Area<B>, left: i32, top: i32) -> Drawn<B> {
    for step in 0..CELL {
        let colour = shade(1.0 - f64::from(step) / f64::from(CELL));
        let corners = [(left, top + step), (left + 16, top + step + 1)];
        area.draw(&Rectangle::new(corners, colour.filled()))?;
    }
    for (share, name) in [(0.0, "1"), (0.5, "0.5"), (1.0, "0")] {
        let y = top + (share * f64::from(CELL)) as i32;
        label(area, (left + 22, y), name, 13, HPos::Left)?;
    }
    label(area, (left, top + CELL + 16), "of the peak", 13, HPos::Left)
}

fn shade(value: f64) -> RGBColor {
    let [r, g, b] = crate::types::heat_colour(value as f32);
    RGBColor(r, g, b)
}

/// A line of text, vertically centred at a pixel.
fn label<B: DrawingBackend>(
    area: &Area<B>,
    at: (i32, i32),
    text: &str,
    size: u32,
    anchor: HPos,
) -> Drawn<B> {
    let style = (FONT, size).into_text_style(area);
    area.draw_text(text, &style.pos(Pos::new(anchor, VPos::Center)), at)
}
