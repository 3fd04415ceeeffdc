//! Phantoms: shapes in which the conductivity is raised.

use crate::pad::Pad;
use crate::types::PointMm;

/// One shape, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A disc.
    Disc {
        /// Its centre.
        centre_mm: PointMm,
        /// Its radius.
        radius_mm: f64,
    },
    /// A ring.
    Annulus {
        /// Its centre.
        centre_mm: PointMm,
        /// Inner and outer radius.
        radii_mm: [f64; 2],
    },
    /// A straight bar with square ends.
    Bar {
        /// The two ends of its axis.
        ends_mm: [PointMm; 2],
        /// Its width.
        width_mm: f64,
    },
}

impl Shape {
    /// Whether the shape contains a point.
    #[must_use]
    pub fn contains(&self, [x, y]: PointMm) -> bool {
        match *self {
            Self::Disc {
                centre_mm: [cx, cy],
                radius_mm,
            } => (x - cx).hypot(y - cy) <= radius_mm,
            Self::Annulus {
                centre_mm: [cx, cy],
                radii_mm: [inner, outer],
            } => (inner..=outer).contains(&(x - cx).hypot(y - cy)),
            Self::Bar {
                ends_mm: [[ax, ay], [bx, by]],
                width_mm,
            } => {
                let (ux, uy) = (bx - ax, by - ay);
                let length = ux.hypot(uy);
                let along = ((x - ax) * ux + (y - ay) * uy) / length;
                let across = ((x - ax) * uy - (y - ay) * ux) / length;
                (0.0..=length).contains(&along) && across.abs() <= width_mm / 2.0
            }
        }
    }

    /// Its centre, mm.
    #[must_use]
    pub fn centre_mm(&self) -> PointMm {
        match *self {
            Self::Disc { centre_mm, .. } | Self::Annulus { centre_mm, .. } => centre_mm,
            Self::Bar {
                ends_mm: [a, b], ..
            } => [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0],
        }
    }

    /// Points on its boundary: if all lie on the pad, so does the shape.
    fn rim_mm(&self) -> Vec<PointMm> {
        const POINTS: usize = 72;
        let circle = |[cx, cy]: PointMm, r: f64| {
            (0..POINTS)
                .map(|i| {
                    let angle = i as f64 * std::f64::consts::TAU / POINTS as f64;
                    [cx + r * angle.cos(), cy + r * angle.sin()]
                })
                .collect()
        };
        match *self {
            Self::Disc {
                centre_mm,
                radius_mm,
            } => circle(centre_mm, radius_mm),
            Self::Annulus {
                centre_mm,
                radii_mm,
            } => circle(centre_mm, radii_mm[1]),
            Self::Bar {
                ends_mm: [a, b],
                width_mm,
            } => {
                let (ux, uy) = (b[0] - a[0], b[1] - a[1]);
                let half = width_mm / 2.0 / ux.hypot(uy);
                [a, b]
                    .into_iter()
                    .flat_map(|[x, y]| {
                        [
                            [x - uy * half, y + ux * half],
                            [x + uy * half, y - ux * half],
                        ]
                    })
                    .collect()
            }
        }
    }
}

/// A named set of shapes, all with the same conductivity.
#[derive(Clone, Debug, PartialEq)]
pub struct Phantom {
    /// Its name in reports.
    pub name: &'static str,
    /// Its shapes.
    pub shapes: Vec<Shape>,
}

impl Phantom {
    /// A phantom of these shapes.
    #[must_use]
    pub fn new(name: &'static str, shapes: Vec<Shape>) -> Self {
        Self { name, shapes }
    }

    /// Discs of one radius.
    #[must_use]
    pub fn discs(name: &'static str, centres_mm: &[PointMm], radius_mm: f64) -> Self {
        let disc = |centre_mm: &PointMm| Shape::Disc {
            centre_mm: *centre_mm,
            radius_mm,
        };
        Self::new(name, centres_mm.iter().map(disc).collect())
    }

    /// One, two and three points of the paper, on a pad of 100 x 100 mm.
    #[must_use]
    pub fn points(radius_mm: f64) -> [Self; 3] {
        let three = [[30.0, 30.0], [70.0, 30.0], [50.0, 70.0]];
        [
            Self::discs("one point", &[[50.0, 50.0]], radius_mm),
            Self::discs("two points", &[[30.0, 50.0], [70.0, 50.0]], radius_mm),
            Self::discs("three points", &three, radius_mm),
        ]
    }

    /// Whether one of its shapes contains a point.
    #[must_use]
    pub fn contains(&self, point: PointMm) -> bool {
        self.shapes.iter().any(|shape| shape.contains(point))
    }

    /// Why the phantom does not fit on a pad; `None` if it does.
    #[must_use]
    pub fn misfit(&self, pad: &Pad) -> Option<String> {
        self.shapes.iter().find_map(|shape| {
            let outside = shape
                .rim_mm()
                .into_iter()
                .find(|point| !pad.outline.contains(*point))?;
            let [x, y] = shape.centre_mm();
            Some(format!(
                "{}: the touch at ({x}, {y}) mm reaches off the pad at ({:.1}, {:.1}) mm",
                self.name, outside[0], outside[1]
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, shipped_pad};

    #[test]
    fn shapes_hold_their_points() {
        let ring = Shape::Annulus {
            centre_mm: [50.0, 50.0],
            radii_mm: [15.0, 25.0],
        };
        assert!(ring.contains([70.0, 50.0]) && !ring.contains([50.0, 50.0]));
        let bar = Shape::Bar {
            ends_mm: [[20.0, 50.0], [80.0, 50.0]],
            width_mm: 10.0,
        };
        assert!(
            bar.contains([50.0, 54.9])
                && !bar.contains([50.0, 55.1])
                && !bar.contains([81.0, 50.0])
        );
    }

    #[test]
    fn a_touch_off_the_pad_is_named() {
        let pad =
            Pad::from_toml("p", shipped_pad(DEFAULT_PAD).expect("shipped").toml).expect("sound");
        let phantom = Phantom::discs("one point", &[[98.0, 50.0]], 5.0);
        let misfit = phantom.misfit(&pad).expect("off the pad");
        assert!(
            misfit.starts_with("one point: the touch at (98, 50) mm reaches off the pad"),
            "{misfit}"
        );
        assert_eq!(
            Phantom::discs("one point", &[[50.0, 50.0]], 5.0).misfit(&pad),
            None
        );
    }
}
