//! A pad from above, with rings that show the errors of place.

use plotters::prelude::*;

use super::{Area, Drawn, FONT, GREY, LINES, Picture, Sign, draw_legend, short};
use crate::pad::{Conductor, Outline, Pad};
use crate::stats::{quantile, range};
use crate::types::PointMm;

/// Colours of the rings and of the discs inside them.
const RING: RGBColor = RGBColor(154, 205, 239);
const DISC: RGBColor = LINES[1];
/// Channels of the lattice.
const CHANNEL: RGBColor = RGBColor(238, 238, 238);
/// A typical ring takes at most this share of the distance to the next place, the largest one at most [`REACH`].
const CLEAR: f64 = 0.46;
/// See [`CLEAR`].
const REACH: f64 = 0.9;
/// A ring is typical up to this quantile of the sizes.
const TYPICAL: f64 = 0.8;
/// Points with which the outline and an electrode are drawn.
const POINTS: (usize, usize) = (180, 6);
/// Room for the legend, pixels.
const LEGEND: u32 = 240;

/// The errors at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// The place, mm.
    pub place_mm: PointMm,
    /// Radius of the ring before it is magnified, mm; not shown unless finite.
    pub outer_mm: f64,
    /// Radius of the disc inside, mm.
    pub inner_mm: f64,
}

/// A map of errors.
#[derive(Clone, Debug)]
pub struct PadMap {
    /// Its title.
    pub title: String,
    /// The pad.
    pub pad: Pad,
    /// The errors.
    pub rings: Vec<Ring>,
    /// Distance between neighbouring places, mm.
    pub pitch_mm: f64,
    /// Meaning of ring and disc.
    pub names: [String; 2],
    /// Lines of text in the legend.
    pub notes: Vec<String>,
}

/// A line through points in mm, drawn in a colour with a width in pixels.
type Stroke = (Vec<(f64, f64)>, RGBColor, u32);

impl Picture for PadMap {
    fn draw_on<B: DrawingBackend>(&self, area: &Area<B>) -> Drawn<B> {
        let [width, height] = self.pad.outline.size_mm();
        let area = area.titled(&self.title, (FONT, 19))?.margin(16, 30, 84, 0);
        let (right, bottom) = area.dim_in_pixel();
        let right = right.saturating_sub(LEGEND);
        let scale = (f64::from(right) / width).min(f64::from(bottom) / height);
        let (plot, side) = area.split_horizontally((width * scale) as u32);
        let (plot, _) = plot.split_vertically((height * scale) as u32);
        let mut chart = ChartBuilder::on(&plot).build_cartesian_2d(0.0..width, 0.0..height)?;
        chart.draw_series(self.channels(scale).into_iter().chain(self.edge()).map(
            |(points, colour, pixels)| PathElement::new(points, colour.stroke_width(pixels)),
        ))?;
        let magnified = self.magnified();
        // Large rings first, so that none hides a small one.
        let mut rings = self.rings.clone();
        rings.sort_by(|a, b| b.outer_mm.total_cmp(&a.outer_mm));
        for (is_outer, colour) in [(true, RING), (false, DISC)] {
            let radius_mm = |ring: &Ring| {
                if is_outer {
                    ring.outer_mm
                } else {
                    ring.inner_mm
                }
            };
            let shown = rings.iter().filter(|ring| radius_mm(ring).is_finite());
            chart.draw_series(shown.map(|ring| {
                let pixels = (radius_mm(ring) * magnified * scale).round().max(1.0);
                Circle::new(ring.place_mm.into(), pixels as i32, colour.filled())
            }))?;
        }
        let factor = format!("drawn {} times as large", short(magnified));
        let names = self.names.iter().zip([Sign::Disc(RING), Sign::Disc(DISC)]);
        let notes = [&factor].into_iter().chain(&self.notes);
        draw_legend(&side, names.chain(notes.map(|note| (note, Sign::None))))
    }
}

impl PadMap {
    /// The factor by which rings are magnified: typical ones stay clear of each other, and none reaches the next place.
    fn magnified(&self) -> f64 {
        let sizes = || {
            let sizes = self
                .rings
                .iter()
                .map(|ring| ring.outer_mm.max(ring.inner_mm));
            sizes.filter(|radius| radius.is_finite() && *radius > 0.0)
        };
        let Some(typical) = quantile(sizes(), TYPICAL) else {
            return 1.0;
        };
        let [_, most] = range(sizes());
        round_below((CLEAR / typical).min(REACH / most) * self.pitch_mm)
    }

    /// The channels of a lattice.
    fn channels(&self, pixels_per_mm: f64) -> Vec<Stroke> {
        let Conductor::Lattice(lattice) = &self.pad.conductor else {
            return Vec::new();
        };
        let [width, height] = self.pad.outline.size_mm();
        let pixels = (lattice.width_mm * pixels_per_mm).round().max(1.0) as u32;
        let upright = lattice.x_lines_mm.iter().map(|x| {
            let [from, to] = self.chord(*x, width, height);
            vec![(*x, from), (*x, to)]
        });
        let level = lattice.y_lines_mm.iter().map(|y| {
            let [from, to] = self.chord(*y, height, width);
            vec![(from, *y), (to, *y)]
        });
        upright
            .chain(level)
            .map(|line| (line, CHANNEL, pixels))
            .collect()
    }

    /// The ends of a line across the pad.
    fn chord(&self, at: f64, across: f64, along: f64) -> [f64; 2] {
        match self.pad.outline {
            Outline::Rectangle { .. } => [0.0, along],
            Outline::Circle { radius_mm } => {
                let off = at - across / 2.0;
                let half = (radius_mm * radius_mm - off * off).max(0.0).sqrt();
                [along / 2.0 - half, along / 2.0 + half]
            }
        }
    }

    /// The outline and the electrodes on it.
    fn edge(&self) -> Vec<Stroke> {
        let outline = &self.pad.outline;
        let along = |[from_mm, to_mm]: [f64; 2], points: usize, corners: &[f64]| {
            let mut stops: Vec<f64> = (0..=points)
                .map(|point| from_mm + (to_mm - from_mm) * point as f64 / points as f64)
                .chain(corners.iter().copied())
                .collect();
            stops.sort_by(f64::total_cmp);
            let points = stops.into_iter().map(|stop| outline.point_at(stop).into());
            points.collect()
        };
        let whole = [0.0, outline.perimeter_mm()];
        let whole = along(whole, POINTS.0, &outline.corners_mm());
        let electrodes = self.pad.electrodes.iter().map(|electrode| {
            let ends = [electrode.start_mm, electrode.end_mm()];
            (along(ends, POINTS.1, &[]), LINES[0], 6)
        });
        std::iter::once((whole, GREY, 2))
            .chain(electrodes)
            .collect()
    }
}

/// The largest of 1, 2, 5, 10, 20 ... at or below a value; below 1 the value itself.
fn round_below(value: f64) -> f64 {
    if !(1.0..1e6).contains(&value) {
        return value.clamp(0.0, 1e6);
    }
    let unit = 10f64.powf(value.log10().floor());
    [5.0, 2.0, 1.0]
        .into_iter()
        .map(|digit| digit * unit)
        .find(|round| *round <= value)
        .unwrap_or(unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn magnifications_are_round() {
        let cases = [(1.0, 1.0), (1.9, 1.0), (7.0, 5.0), (49.0, 20.0), (0.4, 0.4)];
        for (value, round) in cases {
            assert_eq!(round_below(value), round);
        }
    }
}
