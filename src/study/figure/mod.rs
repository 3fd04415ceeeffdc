//! Figures: each drawn once, as SVG and as PNG.

mod axis;
mod chart;
mod gallery;
mod map;
mod panels;

use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

pub use axis::Axis;
pub use chart::{Chart, Look, Series};
pub use gallery::Gallery;
pub use map::{PadMap, Ring};
pub use panels::{Panel, Panels};

use super::StudyError;

/// Width and height of a chart, and of any panel.
const CHART: (u32, u32) = (760, 460);
/// Lines that guide the eye.
const GREY: RGBColor = RGBColor(205, 205, 205);
/// Colours that differ in lightness too (Okabe and Ito), one a line.
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

fn draw_error(error: &dyn std::fmt::Display) -> StudyError {
    StudyError::Internal(format!("a figure cannot be drawn: {error}"))
}

/// Draws into both forms.
fn both<D>(name: &str, caption: &str, size: (u32, u32), draw: D) -> Result<Figure, StudyError>
where
    D: Fn(&mut dyn FnMut(Mark)) -> Result<(), StudyError>,
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
enum Mark {
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
        radius: u32,
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
    shapes: &[Mark],
) -> Result<(), StudyError> {
    use plotters::style::text_anchor::{HPos, Pos, VPos};

    let failed = |error: DrawingAreaErrorKind<B::ErrorType>| draw_error(&error);
    area.fill(&WHITE).map_err(failed)?;
    for shape in shapes {
        match shape {
            Mark::Line {
                points,
                colour,
                width,
            } => area
                .draw(&PathElement::new(
                    points.clone(),
                    colour.stroke_width(*width),
                ))
                .map_err(failed)?,
            Mark::Box { corners, colour } => area
                .draw(&Rectangle::new(*corners, colour.filled()))
                .map_err(failed)?,
            Mark::Dot { at, radius, colour } => area
                .draw(&Circle::new(*at, *radius, colour.filled()))
                .map_err(failed)?,
            Mark::Text {
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

impl Mark {
    /// The same elsewhere.
    fn moved(mut self, (dx, dy): (i32, i32)) -> Self {
        let shift = |(x, y): &mut (i32, i32)| {
            *x += dx;
            *y += dy;
        };
        match &mut self {
            Self::Line { points, .. } => points.iter_mut().for_each(shift),
            Self::Box { corners, .. } => corners.iter_mut().for_each(shift),
            Self::Dot { at, .. } | Self::Text { at, .. } => shift(at),
        }
        self
    }
}

fn text(at: (i32, i32), text: impl Into<String>, size: f64, anchor: i8) -> Mark {
    Mark::Text {
        at,
        text: text.into(),
        size,
        anchor,
        upright: false,
    }
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
}
