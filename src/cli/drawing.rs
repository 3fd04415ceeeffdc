//! Drawings of a profile's regions: SVG and PNG for the screen, SVG at true scale for printing.
//!
//! The printed sheet is cut out and laid on the pad, which has no edges to feel.

use std::fmt::Write as _;

use anyhow::Context as _;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};

use crate::profile::{PlacedRegion, Profile};
use crate::types::PointMm;

/// A4, mm.
const SHEET_MM: [f64; 2] = [210.0, 297.0];
/// Margin that most printers can print, mm.
const MARGIN_MM: f64 = 15.0;
/// Length of the ruler that shows whether the print has the right scale, mm.
const RULER_MM: f64 = 50.0;
/// Pixels per mm on the screen.
const PIXELS_PER_MM: f64 = 6.0;

/// A region placed on a pad.
struct DrawnRegion<'a> {
    name: &'a str,
    placed: PlacedRegion,
}

/// All regions, lowest first: regions on top are drawn last.
fn placed_regions(profile: &Profile, pad_mm: [f64; 2]) -> Vec<DrawnRegion<'_>> {
    let regions = profile.regions.iter().rev();
    regions
        .map(|region| DrawnRegion {
            name: &region.name,
            placed: region.placed(pad_mm, &profile.settings.area),
        })
        .collect()
}

/// The regions on a pad, for the screen.
pub(super) fn svg(profile: &Profile, pad_mm: [f64; 2]) -> String {
    let [width, height] = pad_mm;
    let mut text = head(
        [width * PIXELS_PER_MM, height * PIXELS_PER_MM],
        "",
        pad_mm,
        &profile.name,
    );
    draw_pad(&mut text, profile, pad_mm, [0.0, 0.0]);
    text.push_str("</svg>\n");
    text
}

/// The regions at true scale on an A4 sheet, with a ruler.
pub(super) fn print(profile: &Profile, pad_mm: [f64; 2]) -> anyhow::Result<String> {
    let room = [0, 1].map(|i| SHEET_MM[i] - 2.0 * MARGIN_MM);
    anyhow::ensure!(
        pad_mm[0] <= room[0] && pad_mm[1] <= room[1] - 2.0 * MARGIN_MM,
        "a pad of {} x {} mm does not fit on an A4 sheet at true scale: use --svg and a larger sheet",
        pad_mm[0],
        pad_mm[1]
    );
    let mut text = head(SHEET_MM, "mm", SHEET_MM, &profile.name);
    let (left, top) = ((SHEET_MM[0] - pad_mm[0]) / 2.0, MARGIN_MM * 2.0);
    label(
        &mut text,
        [MARGIN_MM, MARGIN_MM],
        5.0,
        "start",
        &format!("{}: cut along the outer line, print at 100 %", profile.name),
    );
    draw_pad(&mut text, profile, pad_mm, [left, top]);
    let ruler = top + pad_mm[1] + MARGIN_MM;
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "<path d=\"M {left} {} v 5 h {RULER_MM} v -5\" fill=\"none\" stroke=\"#000\" stroke-width=\"0.3\"/>",
        ruler - 5.0
    );
    label(
        &mut text,
        [left + RULER_MM / 2.0, ruler + 5.0],
        4.0,
        "middle",
        &format!("{RULER_MM} mm"),
    );
    text.push_str("</svg>\n");
    Ok(text)
}

fn head(size: [f64; 2], unit: &str, view: [f64; 2], title: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}{unit}\" height=\"{}{unit}\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\">\n<title>{}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        size[0],
        size[1],
        view[0],
        view[1],
        escaped(title)
    )
}

/// Draws outline and regions in mm, with the top-left corner at `at`.
fn draw_pad(text: &mut String, profile: &Profile, pad_mm: [f64; 2], at: PointMm) {
    let place = |[x, y]: PointMm| [at[0] + x, at[1] + pad_mm[1] - y];
    let _ = writeln!(
        text,
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#000\" stroke-width=\"0.4\"/>",
        at[0], at[1], pad_mm[0], pad_mm[1]
    );
    for region in placed_regions(profile, pad_mm) {
        let corners: Vec<String> = region
            .placed
            .corners_mm()
            .into_iter()
            .map(place)
            .map(|[x, y]| format!("{x:.2},{y:.2}"))
            .collect();
        let _ = writeln!(
            text,
            "<polygon points=\"{}\" fill=\"#cfe3f5\" fill-opacity=\"0.6\" stroke=\"#0072b2\" stroke-width=\"0.5\"/>",
            corners.join(" ")
        );
    }
    for region in placed_regions(profile, pad_mm) {
        label(
            text,
            place(region.placed.centre_mm()),
            letter_size_mm(&region),
            "middle",
            region.name,
        );
    }
}

/// Size of letters for which a region's name fits into it, mm.
fn letter_size_mm(region: &DrawnRegion<'_>) -> f64 {
    let (low, high) = region.placed.bounds_mm();
    let fits = (high[0] - low[0]) / (0.62 * region.name.chars().count().max(1) as f64);
    fits.clamp(1.5, 5.0)
}

fn label(text: &mut String, [x, y]: PointMm, size: f64, anchor: &str, name: &str) {
    let _ = writeln!(
        text,
        "<text x=\"{x:.2}\" y=\"{:.2}\" font-size=\"{size:.2}\" text-anchor=\"{anchor}\">{}</text>",
        y + size / 3.0,
        escaped(name)
    );
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// The regions on a pad, as PNG.
pub(super) fn png(profile: &Profile, pad_mm: [f64; 2]) -> anyhow::Result<Vec<u8>> {
    // Registering the font twice has no effect.
    let _ = register_font(
        "sans-serif",
        FontStyle::Normal,
        epaint_default_fonts::UBUNTU_LIGHT,
    );
    let size = pad_mm.map(|mm| (mm * PIXELS_PER_MM).round() as u32);
    let mut pixels = vec![0u8; size[0] as usize * size[1] as usize * 3];
    paint(profile, pad_mm, &mut pixels, (size[0], size[1]))
        .map_err(|error| anyhow::anyhow!("{error}"))?;
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(&pixels))
        .context("the PNG cannot be encoded")?;
    Ok(bytes)
}

fn paint(
    profile: &Profile,
    pad_mm: [f64; 2],
    pixels: &mut [u8],
    size: (u32, u32),
) -> Result<(), Box<dyn std::error::Error>> {
    let place = |[x, y]: PointMm| {
        (
            (x * PIXELS_PER_MM) as i32,
            ((pad_mm[1] - y) * PIXELS_PER_MM) as i32,
        )
    };
    let area = BitMapBackend::with_buffer(pixels, size).into_drawing_area();
    area.fill(&WHITE)?;
    for region in placed_regions(profile, pad_mm) {
        let mut corners: Vec<(i32, i32)> =
            region.placed.corners_mm().into_iter().map(place).collect();
        area.draw(&Polygon::new(
            corners.clone(),
            RGBColor(207, 227, 245).mix(0.6),
        ))?;
        corners.extend(corners.first().copied());
        area.draw(&PathElement::new(
            corners,
            RGBColor(0, 114, 178).stroke_width(2),
        ))?;
    }
    for region in placed_regions(profile, pad_mm) {
        let font = ("sans-serif", letter_size_mm(&region) * PIXELS_PER_MM).into_font();
        let style = TextStyle::from(font).pos(Pos::new(HPos::Center, VPos::Center));
        area.draw(&Text::new(
            region.name.to_owned(),
            place(region.placed.centre_mm()),
            style,
        ))?;
    }
    area.present()?;
    drop(area);
    Ok(())
}
