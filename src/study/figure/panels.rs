//! Several charts and maps in one picture, two side by side.

use super::{CHART, Chart, Figure, PadMap, both, text};
use crate::study::StudyError;

/// Height of the title over all.
const TITLE: i32 = 56;

/// One of them.
#[derive(Clone, Debug)]
pub enum Panel {
    /// Lines.
    Chart(Chart),
    /// Rings on a pad.
    Map(PadMap),
}

/// A picture of panels.
#[derive(Clone, Debug)]
pub struct Panels {
    /// File name without ending.
    pub name: String,
    /// Its title.
    pub title: String,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
}

impl Panels {
    /// Draws it.
    ///
    /// # Errors
    /// The drawing library's.
    pub fn draw(&self) -> Result<Figure, StudyError> {
        const COLUMNS: usize = 2;
        let (width, height) = (CHART.0 as i32, CHART.1 as i32);
        let rows = self.panels.len().div_ceil(COLUMNS) as i32;
        let size = (COLUMNS as u32 * CHART.0, (TITLE + rows * height) as u32);
        both(&self.name, &self.title, size, |put| {
            put(text((84, 30), &self.title, 23.0, -1));
            for (index, panel) in self.panels.iter().enumerate() {
                let (row, column) = ((index / COLUMNS) as i32, (index % COLUMNS) as i32);
                let corner = (column * width, TITLE + row * height);
                let mut there = |mark: super::Mark| put(mark.moved(corner));
                match panel {
                    Panel::Chart(chart) => chart.compose(&mut there),
                    Panel::Map(map) => map.compose(&mut there),
                }
            }
            Ok(())
        })
    }
}
