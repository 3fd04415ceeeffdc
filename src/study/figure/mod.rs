//! Figures, each rendered as SVG and as PNG with plotters.

mod chart;
mod conductance;
mod gallery;
mod map;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

pub use chart::{Axis, Chart, Look, Series};
pub use conductance::ConductanceMap;
pub use gallery::Gallery;
pub use map::{PadMap, Ring};

use super::StudyError;

/// Width and height of a chart, and of any panel, pixels.
const CHART: (u32, u32) = (760, 460);
/// Panels in a row.
const COLUMNS: usize = 2;
/// Height of the title above panels, pixels.
const TITLE: u32 = 40;
/// Font of all figures.
const FONT: &str = "sans-serif";
/// Lengths of a dash and of the gap after it, pixels.
const DASH: (u32, u32) = (7, 5);
/// Grid lines and outlines.
const GREY: RGBColor = RGBColor(205, 205, 205);
/// Colours of the lines of a chart; they differ in lightness too (Okabe and Ito).
const LINES: [RGBColor; 8] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(150, 150, 150),
];

/// A part of a picture, with pixel coordinates.
type Area<B> = DrawingArea<B, Shift>;
/// The result of drawing on a backend.
type Drawn<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

/// A figure in both formats.
#[derive(Clone, Debug)]
pub struct Figure {
    /// File name without ending.
    pub name: String,
    /// What it shows, as text for screen readers.
    pub caption: String,
    /// SVG text.
    pub svg: String,
    /// PNG bytes.
    pub png: Vec<u8>,
}

/// What can be drawn on any backend.
trait Picture {
    fn draw_on<B: DrawingBackend>(&self, area: &Area<B>) -> Drawn<B>;
}

/// Renders a picture in both formats.
fn render(
    name: &str,
    caption: &str,
    size: (u32, u32),
    picture: &impl Picture,
) -> Result<Figure, StudyError> {
    // The bitmap backend has no fonts of its own; registering a font twice is harmless.
    let _ = register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
    let mut svg = String::new();
    paint(SVGBackend::with_string(&mut svg, size), picture)?;
    let mut pixels = vec![0; (size.0 * size.1 * 3) as usize];
    paint(BitMapBackend::with_buffer(&mut pixels, size), picture)?;
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, size.0, size.1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(&pixels))
        .map_err(StudyError::internal)?;
    Ok(Figure {
        name: name.to_owned(),
        caption: caption.to_owned(),
        svg,
        png,
    })
}

fn paint<B: DrawingBackend>(backend: B, picture: &impl Picture) -> Result<(), StudyError> {
    let area = backend.into_drawing_area();
    area.fill(&WHITE)
        .and_then(|()| picture.draw_on(&area))
        .and_then(|()| area.present())
        .map_err(StudyError::internal)
}

/// The sign of an entry of a legend.
#[derive(Clone, Copy, Debug)]
enum Sign {
    Line(RGBColor),
    Dashes(RGBColor),
    Disc(RGBColor),
    None,
}

/// Draws a legend. Plotters clips a legend to its chart, so this is an empty chart next to the real one.
fn draw_legend<'n, B: DrawingBackend>(
    area: &Area<B>,
    entries: impl IntoIterator<Item = (&'n String, Sign)>,
) -> Drawn<B> {
    let mut chart = ChartBuilder::on(area).build_cartesian_2d(0..1, 0..1)?;
    for (name, sign) in entries {
        let entry = chart.draw_series(std::iter::empty::<Circle<(i32, i32), i32>>())?;
        let ends = |(x, y)| vec![(x, y), (x + 24, y)];
        match sign {
            Sign::Line(colour) => entry
                .label(name)
                .legend(move |p| PathElement::new(ends(p), colour.stroke_width(2))),
            Sign::Dashes(colour) => entry.label(name).legend(move |p| {
                DashedPathElement::new(ends(p), DASH.0, DASH.1, colour.stroke_width(2))
            }),
            Sign::Disc(colour) => entry
                .label(name)
                .legend(move |(x, y)| Circle::new((x + 12, y), 6, colour.filled())),
            Sign::None => entry.label(name),
        };
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .label_font((FONT, 14))
        .draw()
}

/// One of several pictures in a figure.
#[derive(Clone, Debug)]
pub enum Panel {
    /// Lines.
    Chart(Chart),
    /// Rings on a pad.
    Map(Box<PadMap>),
}

/// A figure of several panels, two in a row.
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
    /// Renders the figure.
    ///
    /// # Errors
    /// An error of the drawing library.
    pub fn draw(&self) -> Result<Figure, StudyError> {
        let rows = self.panels.len().div_ceil(COLUMNS) as u32;
        let size = (COLUMNS as u32 * CHART.0, TITLE + rows * CHART.1);
        render(&self.name, &self.title, size, self)
    }
}

impl Picture for Panels {
    fn draw_on<B: DrawingBackend>(&self, area: &Area<B>) -> Drawn<B> {
        let rows = self.panels.len().div_ceil(COLUMNS);
        let (title, area) = area.split_vertically(TITLE);
        title.margin(6, 0, 0, 0).titled(&self.title, (FONT, 23))?;
        for (panel, area) in self.panels.iter().zip(area.split_evenly((rows, COLUMNS))) {
            match panel {
                Panel::Chart(chart) => chart.draw_on(&area)?,
                Panel::Map(map) => map.draw_on(&area)?,
            }
        }
        Ok(())
    }
}

/// A number with three significant digits.
#[must_use]
pub fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return "-".to_owned();
    }
    let digits = 2 - value.abs().log10().floor() as i32;
    if !(-3..=6).contains(&digits) {
        return format!("{value:.2e}");
    }
    let text = format!("{value:.*}", digits.max(0) as usize);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.0, "0"),
            (1234.0, "1234"),
            (0.012_34, "0.0123"),
            (2.0, "2"),
            (1.5e-9, "1.50e-9"),
        ];
        for (value, text) in cases {
            assert_eq!(short(value), text);
        }
    }
}
