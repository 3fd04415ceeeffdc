//! Figures: each drawn once, as SVG and as PNG.

use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

use super::{Raster, StudyError};

/// Width and height of a chart.
const CHART: (u32, u32) = (760, 460);
/// Colours that differ in lightness too (Okabe and Ito), one a line.
const LINES: [RGBColor; 6] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
];

/// A figure in both forms.
#[derive(Clone, Debug)]
pub struct Figure {
    /// File name without ending.
    pub name: String,
    /// What it shows, for people who cannot see it too.
    pub caption: String,
    /// SVG text.
    pub svg: String,
    /// PNG bytes.
    pub png: Vec<u8>,
}

/// One line of a chart, with the range about each point if it has one.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Height at each place along x, least and greatest.
    pub points: Vec<[f64; 3]>,
}

/// A chart of lines over named places.
#[derive(Clone, Debug)]
pub struct Chart {
    /// File name without ending.
    pub name: String,
    /// Its title.
    pub title: String,
    /// Name of the x axis.
    pub x_label: String,
    /// Name and unit of the y axis.
    pub y_label: String,
    /// Names of the places along x.
    pub places: Vec<String>,
    /// The lines.
    pub series: Vec<Series>,
}

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

fn draw_error(error: &dyn std::fmt::Display) -> StudyError {
    StudyError::Internal(format!("a figure cannot be drawn: {error}"))
}

/// Draws into both forms.
fn both<D>(name: &str, caption: &str, size: (u32, u32), draw: D) -> Result<Figure, StudyError>
where
    D: Fn(&mut dyn FnMut(Shape2)) -> Result<(), StudyError>,
{
    // The bitmap needs glyphs of its own; registering the same font again is harmless.
    let _ = register_font(
        "sans-serif",
        FontStyle::Normal,
        epaint_default_fonts::UBUNTU_LIGHT,
    );
    let mut shapes = Vec::new();
    draw(&mut |shape| shapes.push(shape))?;
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        paint(&area, &shapes)?;
    }
    let mut pixels = vec![0u8; (size.0 * size.1 * 3) as usize];
    {
        let area = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
        paint(&area, &shapes)?;
    }
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, size.0, size.1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(&pixels))
        .map_err(|error| draw_error(&error))?;
    Ok(Figure {
        name: name.to_owned(),
        caption: caption.to_owned(),
        svg,
        png,
    })
}

/// What figures are made of, in pixels from the top-left.
#[derive(Clone, Debug)]
enum Shape2 {
    Line {
        points: Vec<(i32, i32)>,
        colour: RGBColor,
        width: u32,
    },
    Box {
        corners: [(i32, i32); 2],
        colour: RGBColor,
    },
    Dot {
        at: (i32, i32),
        colour: RGBColor,
    },
    Text {
        at: (i32, i32),
        text: String,
        size: f64,
        /// -1 begins there, 0 is centred there, 1 ends there.
        anchor: i8,
        upright: bool,
    },
}

fn paint<B: DrawingBackend>(
    area: &DrawingArea<B, plotters::coord::Shift>,
    shapes: &[Shape2],
) -> Result<(), StudyError> {
    use plotters::style::text_anchor::{HPos, Pos, VPos};

    let failed = |error: DrawingAreaErrorKind<B::ErrorType>| draw_error(&error);
    area.fill(&WHITE).map_err(failed)?;
    for shape in shapes {
        match shape {
            Shape2::Line {
                points,
                colour,
                width,
            } => area
                .draw(&PathElement::new(
                    points.clone(),
                    colour.stroke_width(*width),
                ))
                .map_err(failed)?,
            Shape2::Box { corners, colour } => area
                .draw(&Rectangle::new(*corners, colour.filled()))
                .map_err(failed)?,
            Shape2::Dot { at, colour } => area
                .draw(&Circle::new(*at, 4, colour.filled()))
                .map_err(failed)?,
            Shape2::Text {
                at,
                text,
                size,
                anchor,
                upright,
            } => {
                let horizontal = match anchor {
                    -1 => HPos::Left,
                    0 => HPos::Center,
                    _ => HPos::Right,
                };
                let mut style = ("sans-serif", *size).into_text_style(area);
                if *upright {
                    style = style.transform(FontTransform::Rotate270);
                }
                let style = style.pos(Pos::new(horizontal, VPos::Center)).color(&BLACK);
                area.draw(&Text::new(text.as_str(), *at, style))
                    .map_err(failed)?;
            }
        }
    }
    area.present().map_err(failed)
}

fn text(at: (i32, i32), text: impl Into<String>, size: f64, anchor: i8) -> Shape2 {
    Shape2::Text {
        at,
        text: text.into(),
        size,
        anchor,
        upright: false,
    }
}

/// A round number at or above a value, and how many steps make it.
fn scale(highest: f64) -> (f64, usize) {
    if highest <= 0.0 || !highest.is_finite() {
        return (1.0, 4);
    }
    let unit = 10f64.powf(highest.log10().floor());
    for (factor, steps) in [
        (1.0, 5),
        (1.5, 3),
        (2.0, 4),
        (3.0, 3),
        (4.0, 4),
        (5.0, 5),
        (6.0, 3),
        (8.0, 4),
    ] {
        if highest <= factor * unit * 1.000_001 {
            return (factor * unit, steps);
        }
    }
    (10.0 * unit, 5)
}

/// A number with three digits.
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

impl Chart {
    /// Draws it.
    ///
    /// # Errors
    /// The drawing library's.
    pub fn draw(&self) -> Result<Figure, StudyError> {
        let caption = format!("{}: {} over {}", self.title, self.y_label, self.x_label);
        both(&self.name, &caption, CHART, |put| {
            self.compose(put);
            Ok(())
        })
    }

    fn compose(&self, put: &mut dyn FnMut(Shape2)) {
        const GREY: RGBColor = RGBColor(205, 205, 205);
        let (left, right, top, bottom) = (84, CHART.0 as i32 - 180, 48, CHART.1 as i32 - 58);
        let highest = self
            .series
            .iter()
            .flat_map(|series| series.points.iter().map(|[_, _, most]| *most))
            .filter(|value| value.is_finite())
            .fold(0.0, f64::max);
        let (end, steps) = scale(highest);
        let x_of = |place: usize| {
            let share = (place as f64 + 0.5) / self.places.len().max(1) as f64;
            left + (f64::from(right - left) * share) as i32
        };
        let y_of =
            |value: f64| bottom - (f64::from(bottom - top) * (value / end).clamp(0.0, 1.0)) as i32;
        put(text((left, 22), &self.title, 19.0, -1));
        for step in 0..=steps {
            let value = end * step as f64 / steps as f64;
            let y = y_of(value);
            put(Shape2::Line {
                points: vec![(left, y), (right, y)],
                colour: GREY,
                width: 1,
            });
            put(text((left - 8, y), short(value), 14.0, 1));
        }
        // Names along x, thinned out where they would run into each other.
        let every = self.places.len().div_ceil(12).max(1);
        for (place, name) in self.places.iter().enumerate().step_by(every) {
            put(text((x_of(place), bottom + 16), name, 14.0, 0));
        }
        put(text(
            ((left + right) / 2, bottom + 42),
            &self.x_label,
            15.0,
            0,
        ));
        put(Shape2::Text {
            at: (20, (top + bottom) / 2),
            text: self.y_label.clone(),
            size: 15.0,
            anchor: 0,
            upright: true,
        });
        for (index, series) in self.series.iter().enumerate() {
            let colour = LINES[index % LINES.len()];
            // Ranges of several lines stand side by side.
            let shift = 5 * (index as i32 - self.series.len() as i32 / 2);
            let at = |place: usize, value: f64| (x_of(place), y_of(value));
            let line = series
                .points
                .iter()
                .enumerate()
                .filter(|(_, [mean, ..])| mean.is_finite())
                .map(|(place, [mean, ..])| at(place, *mean))
                .collect();
            put(Shape2::Line {
                points: line,
                colour,
                width: 2,
            });
            for (place, [mean, least, most]) in series.points.iter().enumerate() {
                if !mean.is_finite() {
                    continue;
                }
                if most > least {
                    let [from, to] = [*least, *most].map(|value| {
                        let (x, y) = at(place, value);
                        (x + shift, y)
                    });
                    put(Shape2::Line {
                        points: vec![from, to],
                        colour,
                        width: 1,
                    });
                }
                put(Shape2::Dot {
                    at: at(place, *mean),
                    colour,
                });
            }
            let y = top + 10 + 22 * index as i32;
            put(Shape2::Line {
                points: vec![(right + 14, y), (right + 38, y)],
                colour,
                width: 2,
            });
            put(text((right + 44, y), &series.name, 14.0, -1));
        }
    }
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
                put(Shape2::Box {
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

fn picture(raster: &Raster, (x0, y0): (i32, i32), edge: i32, put: &mut dyn FnMut(Shape2)) {
    let peak = raster.peak().max(f64::MIN_POSITIVE);
    let (columns, rows) = (raster.grid.columns, raster.grid.rows);
    let most = columns.max(rows) as f64;
    let at = |cell: usize| (cell as f64 / most * f64::from(edge)) as i32;
    for row in 0..rows {
        for column in 0..columns {
            let value = raster.values[row * columns + column] / peak;
            let (top, left) = (at(rows - 1 - row), at(column));
            put(Shape2::Box {
                corners: [
                    (x0 + left, y0 + top),
                    (x0 + at(column + 1), y0 + at(rows - row)),
                ],
                colour: shade(value),
            });
        }
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
        for (value, said) in cases {
            assert_eq!(short(value), said);
        }
    }

    #[test]
    fn a_chart_is_drawn_in_both_forms_and_the_same_each_time() {
        let chart = Chart {
            name: "c".to_owned(),
            title: "Title".to_owned(),
            x_label: "width".to_owned(),
            y_label: "change".to_owned(),
            places: vec!["solid".to_owned(), "1 mm".to_owned()],
            series: vec![Series {
                name: "one point".to_owned(),
                points: vec![[1.0, 0.5, 1.5], [2.0, 2.0, 2.0]],
            }],
        };
        let (a, b) = (chart.draw().expect("drawn"), chart.draw().expect("drawn"));
        assert!(a.svg.contains("Title") && a.svg.starts_with("<svg"));
        assert_eq!(&a.png[1..4], b"PNG");
        assert_eq!((a.svg, a.png), (b.svg, b.png));
    }
}
