//! Pads from above, coloured by how well each cell of the layer conducts, with the electrodes where they are.

use plotters::prelude::*;

use super::{Area, Drawn, FONT, Figure, GREY, LINES, Picture, TITLE, render};
use crate::pad::{Conductor, Electrode, Pad, cell_sites_mm};
use crate::study::StudyError;
use crate::types::PointMm;

/// Size of a pad's picture, pixels.
const PANEL: (u32, u32) = (560, 600);
/// Factors from one over this to this span the colours.
const MOST_FACTOR: f64 = 1.5;
/// Ends of the scale and its middle: worse, as the layer, better. Their lightness differs, so that they are told apart without colours.
const WORSE: RGBColor = RGBColor(178, 66, 0);
const SAME: RGBColor = RGBColor(222, 222, 222);
const BETTER: RGBColor = RGBColor(0, 70, 140);
/// Marks of the scale.
const MARKS: [f64; 5] = [0.67, 0.8, 1.0, 1.25, 1.5];
/// Points with which an electrode is drawn, and half the length of a cell of a layer without channels in distances of sites.
const POINTS: usize = 6;

/// Conductance of one or more pads, side by side.
#[derive(Clone, Debug)]
pub struct ConductanceMap {
    /// File name without ending.
    pub name: String,
    /// Its title.
    pub title: String,
    /// The pads with their captions.
    pub pads: Vec<(String, Pad)>,
}

impl ConductanceMap {
    /// Renders the figure.
    ///
    /// # Errors
    /// An error of the drawing library.
    pub fn draw(&self) -> Result<Figure, StudyError> {
        let size = (self.pads.len().max(1) as u32 * PANEL.0, TITLE + PANEL.1);
        render(&self.name, &self.title, size, self)
    }
}

impl Picture for ConductanceMap {
    fn draw_on<B: DrawingBackend>(&self, area: &Area<B>) -> Drawn<B> {
        let (title, area) = area.split_vertically(TITLE);
        title.margin(6, 0, 0, 0).titled(&self.title, (FONT, 23))?;
        let panels = area.split_evenly((1, self.pads.len().max(1)));
        for ((caption, pad), panel) in self.pads.iter().zip(&panels) {
            draw_pad(panel, caption, pad)?;
        }
        Ok(())
    }
}

fn draw_pad<B: DrawingBackend>(area: &Area<B>, caption: &str, pad: &Pad) -> Drawn<B> {
    let (area, scale) = area.split_vertically(PANEL.1 - 60);
    let area = area.titled(caption, (FONT, 17))?.margin(12, 12, 24, 24);
    let [width, height] = pad.outline.size_mm();
    let (right, bottom) = area.dim_in_pixel();
    let pixels_per_mm = (f64::from(right) / width).min(f64::from(bottom) / height);
    let plot = area.shrink(
        (0, 0),
        (
            (width * pixels_per_mm) as u32,
            (height * pixels_per_mm) as u32,
        ),
    );
    let mut chart = ChartBuilder::on(&plot).build_cartesian_2d(0.0..width, 0.0..height)?;
    let cells = cell_strokes(pad).into_iter().map(|cell| {
        let pixels = (cell.width_mm * pixels_per_mm).round().max(2.0) as u32;
        let ends = cell.ends_mm.map(PointMm::into).to_vec();
        PathElement::new(ends, colour(cell.factor).stroke_width(pixels))
    });
    chart.draw_series(cells)?;
    let drawing = pad.drawing();
    let drawn = drawing
        .electrodes
        .iter()
        .map(|e| (stroke(pad, e), GREY, 12));
    let found = pad.electrodes.iter().map(|e| (stroke(pad, e), LINES[0], 6));
    let strokes = drawn
        .chain(found)
        .map(|(points, colour, pixels)| PathElement::new(points, colour.stroke_width(pixels)));
    chart.draw_series(strokes)?;
    draw_scale(&scale)
}

/// A cell of the layer as a stroke.
struct CellStroke {
    ends_mm: [PointMm; 2],
    width_mm: f64,
    /// Conductance as a multiple of that of the drawing.
    factor: f64,
}

/// The cells: pieces of channel of a lattice, squares of a solid layer.
fn cell_strokes(pad: &Pad) -> Vec<CellStroke> {
    let sites = cell_sites_mm(pad);
    // Sites of a line follow each other.
    let steps = sites
        .windows(2)
        .map(|pair| libm::hypot(pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]));
    let step_mm = steps.fold(f64::INFINITY, f64::min);
    let (x_lines_mm, width_mm) = match &pad.conductor {
        Conductor::Lattice(lattice) => (lattice.x_lines_mm.as_slice(), lattice.width_mm),
        _ => (&[][..], step_mm),
    };
    let cell_at = |site: PointMm| {
        let is_upright = x_lines_mm.iter().any(|x| (x - site[0]).abs() < 1e-6);
        let half = match is_upright {
            true => [0.0, 0.5 * step_mm],
            false => [0.5 * step_mm, 0.0],
        };
        CellStroke {
            ends_mm: [-1.0, 1.0].map(|side| [0, 1].map(|axis| site[axis] + side * half[axis])),
            width_mm,
            factor: pad.deviations.factor_at(site),
        }
    };
    sites.into_iter().map(cell_at).collect()
}

fn stroke(pad: &Pad, electrode: &Electrode) -> Vec<(f64, f64)> {
    let along = (0..=POINTS).map(|point| {
        let share = point as f64 / POINTS as f64;
        pad.outline
            .point_at(electrode.start_mm + share * electrode.width_mm)
            .into()
    });
    along.collect()
}

fn draw_scale<B: DrawingBackend>(area: &Area<B>) -> Drawn<B> {
    let style = (FONT, 14).into_font().color(&BLACK);
    for (index, factor) in MARKS.into_iter().enumerate() {
        let left = 24 + 88 * index as i32;
        let corner = [(left, 4), (left + 24, 20)];
        area.draw(&Rectangle::new(corner, colour(factor).filled()))?;
        area.draw_text(&format!("{:.0} %", 100.0 * factor), &style, (left + 30, 6))?;
    }
    let note = "black: electrodes as found; grey: as drawn";
    area.draw_text(note, &style, (24, 30))
}

fn colour(factor: f64) -> RGBColor {
    let share = (libm::log(factor) / libm::log(MOST_FACTOR)).clamp(-1.0, 1.0);
    let end = if share < 0.0 { WORSE } else { BETTER };
    let mix = |from: u8, to: u8| {
        (f64::from(from) + share.abs() * (f64::from(to) - f64::from(from))).round() as u8
    };
    RGBColor(mix(SAME.0, end.0), mix(SAME.1, end.1), mix(SAME.2, end.2))
}
