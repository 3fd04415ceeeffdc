//! A pad from above, with rings that show how far off touches are there.

use plotters::style::RGBColor;

use super::{CHART, GREY, LINES, Mark, short, text};
use crate::pad::{Conductor, Outline, Pad};
use crate::types::PointMm;

/// Colours of the outer ring and of the inner disc.
const RING: RGBColor = RGBColor(154, 205, 239);
const DISC: RGBColor = LINES[1];
/// The usual ring takes at most this share of the distance to the next place, the largest one that share.
const CLEAR: f64 = 0.46;
const REACH: f64 = 0.9;
/// Usual: not larger than the ring at this share of all, by size.
const MOST_OF_THEM: f64 = 0.8;
/// Points with which the outline and an electrode are drawn.
const POINTS: (usize, usize) = (180, 6);

/// What is shown at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Where, mm.
    pub place_mm: PointMm,
    /// Radius of the ring, mm before it is magnified; none is shown unless it is finite.
    pub outer_mm: f64,
    /// Radius of the disc in it.
    pub inner_mm: f64,
}

/// A map.
#[derive(Clone, Debug)]
pub struct PadMap {
    /// Its title.
    pub title: String,
    /// The pad.
    pub pad: Pad,
    /// What is shown.
    pub rings: Vec<Ring>,
    /// Distance between neighbouring places, mm.
    pub pitch_mm: f64,
    /// What ring and disc mean.
    pub names: [String; 2],
    /// Lines of text beneath.
    pub notes: Vec<String>,
}

/// From millimetres to pixels.
#[derive(Clone, Copy)]
struct View {
    scale: f64,
    left: i32,
    bottom: i32,
}

impl View {
    fn at(self, [x, y]: PointMm) -> (i32, i32) {
        let [x, y] = [x, y].map(|mm| (mm * self.scale).round() as i32);
        (self.left + x, self.bottom - y)
    }
}

impl PadMap {
    pub(super) fn compose(&self, put: &mut dyn FnMut(Mark)) {
        let (left, right, top, bottom) = (84, CHART.0 as i32 - 240, 48, CHART.1 as i32 - 30);
        let [width, height] = self.pad.outline.size_mm();
        let view = View {
            scale: (f64::from(right - left) / width).min(f64::from(bottom - top) / height),
            left,
            bottom,
        };
        put(text((left, 22), &self.title, 19.0, -1));
        self.channels(view, put);
        self.edge(view, put);
        let magnified = self.magnified();
        let pixels = |radius_mm: f64| (radius_mm * magnified * view.scale).round() as u32;
        // Large ones first, so that none hides a small one.
        let mut rings = self.rings.clone();
        rings.sort_by(|a, b| b.outer_mm.total_cmp(&a.outer_mm));
        type Radius = fn(&Ring) -> f64;
        let radii: [(Radius, RGBColor); 2] =
            [(|ring| ring.outer_mm, RING), (|ring| ring.inner_mm, DISC)];
        for (radius, colour) in radii {
            for ring in rings.iter().filter(|ring| radius(ring).is_finite()) {
                put(Mark::Dot {
                    at: view.at(ring.place_mm),
                    radius: pixels(radius(ring)).max(1),
                    colour,
                });
            }
        }
        let legend = left + (width * view.scale) as i32 + 30;
        for (line, (name, colour)) in self.names.iter().zip([RING, DISC]).enumerate() {
            let y = top + 10 + 22 * line as i32;
            put(Mark::Dot {
                at: (legend + 6, y),
                radius: 6,
                colour,
            });
            put(text((legend + 20, y), name, 14.0, -1));
        }
        let said = format!("drawn {} times as large", short(magnified));
        for (line, note) in [said].iter().chain(&self.notes).enumerate() {
            let y = top + 68 + 18 * line as i32;
            put(text((legend, y), note, 13.0, -1));
        }
    }

    /// How many times as large rings are drawn: most of them stay clear of each other, and none reaches the next place.
    fn magnified(&self) -> f64 {
        let mut sizes: Vec<f64> = self
            .rings
            .iter()
            .map(|ring| ring.outer_mm.max(ring.inner_mm))
            .filter(|radius| radius.is_finite() && *radius > 0.0)
            .collect();
        sizes.sort_by(f64::total_cmp);
        let Some(most) = sizes.last() else { return 1.0 };
        let usual = sizes[(MOST_OF_THEM * (sizes.len() - 1) as f64) as usize];
        round_below((CLEAR / usual).min(REACH / most) * self.pitch_mm)
    }

    fn channels(&self, view: View, put: &mut dyn FnMut(Mark)) {
        let Conductor::Lattice(lattice) = &self.pad.conductor else {
            return;
        };
        let [width, height] = self.pad.outline.size_mm();
        let stroke = (lattice.width_mm * view.scale).round().max(1.0) as u32;
        let mut line = |ends: [PointMm; 2]| {
            put(Mark::Line {
                points: ends.map(|end| view.at(end)).to_vec(),
                colour: RGBColor(238, 238, 238),
                width: stroke,
            });
        };
        for x in &lattice.x_lines_mm {
            let [from, to] = self.chord(*x, width, height);
            line([[*x, from], [*x, to]]);
        }
        for y in &lattice.y_lines_mm {
            let [from, to] = self.chord(*y, height, width);
            line([[from, *y], [to, *y]]);
        }
    }

    /// Where a line across the pad enters and leaves it.
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

    /// The outline, and the electrodes on it.
    fn edge(&self, view: View, put: &mut dyn FnMut(Mark)) {
        let outline = &self.pad.outline;
        let mut stretch =
            |[from_mm, to_mm]: [f64; 2], points: usize, corners: &[f64], colour, width| {
                let mut along: Vec<f64> = (0..=points)
                    .map(|point| from_mm + (to_mm - from_mm) * point as f64 / points as f64)
                    .chain(corners.iter().copied())
                    .collect();
                along.sort_by(f64::total_cmp);
                put(Mark::Line {
                    points: along
                        .into_iter()
                        .map(|s| view.at(outline.point_at(s)))
                        .collect(),
                    colour,
                    width,
                });
            };
        let whole = [0.0, outline.perimeter_mm()];
        stretch(whole, POINTS.0, &outline.corners_mm(), GREY, 2);
        for electrode in &self.pad.electrodes {
            let ends = [electrode.start_mm, electrode.end_mm()];
            stretch(ends, POINTS.1, &[], LINES[0], 6);
        }
    }
}

/// The last of 1, 2, 5, 10, 20 ... at or below a value; below 1 the value itself.
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
