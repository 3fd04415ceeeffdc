//! Regions: as written, in shares of the pad, and as placed on a pad, in mm.

use super::settings::Area;
use crate::types::PointMm;

/// Tolerance for rounding: an edge belongs to its region.
const EDGE_MM: f64 = 1e-9;

/// The outline of a region; all numbers 0..1 of the pad, origin at the bottom-left.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Bottom-left corner, width and height.
    Rect {
        /// Left.
        x: f64,
        /// Bottom.
        y: f64,
        /// Width.
        w: f64,
        /// Height.
        h: f64,
    },
    /// Centre, and radius in shares of the pad's shorter side.
    Circle {
        /// Centre.
        x: f64,
        /// Centre.
        y: f64,
        /// Radius.
        r: f64,
    },
    /// Centre, width and height.
    Ellipse {
        /// Centre.
        x: f64,
        /// Centre.
        y: f64,
        /// Width.
        w: f64,
        /// Height.
        h: f64,
    },
    /// Corners, clockwise or counter-clockwise.
    Polygon(Vec<[f64; 2]>),
}

/// The effect of a touch that moves out of a region or into it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slide {
    /// It belongs to the region where it began.
    Keep,
    /// It lets go when it leaves.
    Leave,
    /// It lets go when it leaves, and presses where it arrives.
    Across,
}

/// A named part of the pad.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Its name.
    pub name: String,
    /// Its outline.
    pub shape: Shape,
    /// Takes touches this far outside too; share of the pad's shorter side.
    pub reach: f64,
    /// Keeps a touch that holds it this far outside.
    pub held_reach: f64,
    /// Whether a touch in it does not count for regions below.
    pub exclusive: bool,
    /// The effect of a touch that moves.
    pub slide: Slide,
    /// Share of a touch's radius that counts: 0 for its centre only.
    pub footprint: f64,
    /// Whether touches that begin in it are ignored.
    pub rest: bool,
    /// Whether it is a cell of a grid, whose name is a number that players need not know.
    pub is_cell: bool,
}

/// A region on a pad of a known size, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedRegion {
    outline: Outline,
    /// The shorter side of the pad.
    unit_mm: f64,
}

#[derive(Clone, Debug, PartialEq)]
enum Outline {
    Rect { low: PointMm, high: PointMm },
    Ellipse { centre: PointMm, radii: PointMm },
    Polygon(Vec<PointMm>),
}

impl Region {
    /// The region in an area of a pad of a size, as the player sees it.
    #[must_use]
    pub fn placed(&self, [width, height]: [f64; 2], area: &Area) -> PlacedRegion {
        let (w_mm, h_mm) = (area.w * width, area.h * height);
        let at = |x: f64, y: f64| {
            [
                (area.x + x * area.w) * width,
                (area.y + y * area.h) * height,
            ]
        };
        let unit_mm = w_mm.min(h_mm);
        let outline = match &self.shape {
            Shape::Rect { x, y, w, h } => Outline::Rect {
                low: at(*x, *y),
                high: at(x + w, y + h),
            },
            Shape::Circle { x, y, r } => Outline::Ellipse {
                centre: at(*x, *y),
                radii: [r * unit_mm, r * unit_mm],
            },
            Shape::Ellipse { x, y, w, h } => Outline::Ellipse {
                centre: at(*x, *y),
                radii: [w / 2.0 * w_mm, h / 2.0 * h_mm],
            },
            Shape::Polygon(points) => {
                Outline::Polygon(points.iter().map(|[x, y]| at(*x, *y)).collect())
            }
        };
        PlacedRegion { outline, unit_mm }
    }
}

impl PlacedRegion {
    /// Whether it contains a place, if widened by a share of the pad; edges belong to it.
    #[must_use]
    pub fn contains(&self, point: PointMm, reach: f64) -> bool {
        self.distance_mm(point) <= self.reach_mm(reach)
    }

    /// A share of the pad's shorter side, in mm.
    #[must_use]
    pub fn reach_mm(&self, reach: f64) -> f64 {
        reach * self.unit_mm + EDGE_MM
    }

    /// Distance of a place from the region, mm; zero inside. For an ellipse, along the line to its centre.
    #[must_use]
    pub fn distance_mm(&self, [x, y]: PointMm) -> f64 {
        match &self.outline {
            Outline::Rect { low, high } => {
                let dx = (low[0] - x).max(x - high[0]).max(0.0);
                let dy = (low[1] - y).max(y - high[1]).max(0.0);
                if dx == 0.0 || dy == 0.0 {
                    return dx + dy;
                }
                libm::sqrt(dx * dx + dy * dy)
            }
            Outline::Ellipse { centre, radii } => {
                let (dx, dy) = (x - centre[0], y - centre[1]);
                let (u, v) = (dx / radii[0], dy / radii[1]);
                let share = libm::sqrt(u * u + v * v);
                if share <= 1.0 {
                    return 0.0;
                }
                libm::sqrt(dx * dx + dy * dy) * (1.0 - 1.0 / share)
            }
            Outline::Polygon(corners) => polygon_distance_mm(corners, [x, y]),
        }
    }

    /// The centre of its bounding box.
    #[must_use]
    pub fn centre_mm(&self) -> PointMm {
        let (low, high) = self.bounds_mm();
        [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0]
    }

    /// Half of the shorter side of its bounding box, mm.
    #[must_use]
    pub fn radius_mm(&self) -> f64 {
        let (low, high) = self.bounds_mm();
        (high[0] - low[0]).min(high[1] - low[1]) / 2.0
    }

    /// Bottom-left and top-right corners of its bounding box.
    #[must_use]
    pub fn bounds_mm(&self) -> (PointMm, PointMm) {
        match &self.outline {
            Outline::Rect { low, high } => (*low, *high),
            Outline::Ellipse { centre, radii } => (
                [centre[0] - radii[0], centre[1] - radii[1]],
                [centre[0] + radii[0], centre[1] + radii[1]],
            ),
            Outline::Polygon(corners) => {
                let mut low = [f64::INFINITY; 2];
                let mut high = [f64::NEG_INFINITY; 2];
                for corner in corners {
                    for i in 0..2 {
                        low[i] = low[i].min(corner[i]);
                        high[i] = high[i].max(corner[i]);
                    }
                }
                (low, high)
            }
        }
    }

    /// Its outline as corners; 72 for an ellipse.
    #[must_use]
    pub fn corners_mm(&self) -> Vec<PointMm> {
        const ROUND: usize = 72;
        match &self.outline {
            Outline::Rect { low, high } => {
                vec![*low, [high[0], low[1]], *high, [low[0], high[1]]]
            }
            Outline::Ellipse { centre, radii } => (0..ROUND)
                .map(|i| {
                    let angle = core::f64::consts::TAU * i as f64 / ROUND as f64;
                    [
                        centre[0] + radii[0] * libm::cos(angle),
                        centre[1] + radii[1] * libm::sin(angle),
                    ]
                })
                .collect(),
            Outline::Polygon(corners) => corners.clone(),
        }
    }
}

/// Distance to the nearest edge; zero inside, which is found by counting the edges that a ray to the right crosses.
fn polygon_distance_mm(corners: &[PointMm], [x, y]: PointMm) -> f64 {
    let mut inside = false;
    let mut nearest = f64::INFINITY;
    for (i, b) in corners.iter().enumerate() {
        let a = corners[(i + corners.len() - 1) % corners.len()];
        if (a[1] > y) != (b[1] > y) && x < (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]) + a[0] {
            inside = !inside;
        }
        let (ex, ey) = (b[0] - a[0], b[1] - a[1]);
        let along =
            ((x - a[0]) * ex + (y - a[1]) * ey) / (ex * ex + ey * ey).max(f64::MIN_POSITIVE);
        let along = along.clamp(0.0, 1.0);
        let (dx, dy) = (x - a[0] - along * ex, y - a[1] - along * ey);
        nearest = nearest.min(dx * dx + dy * dy);
    }
    if inside { 0.0 } else { libm::sqrt(nearest) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAD_MM: [f64; 2] = [100.0, 80.0];

    fn placed(shape: Shape) -> PlacedRegion {
        let region = Region {
            name: "r".to_owned(),
            shape,
            reach: 0.0,
            held_reach: 0.0,
            exclusive: true,
            slide: Slide::Keep,
            footprint: 0.0,
            rest: false,
            is_cell: false,
        };
        region.placed(PAD_MM, &Area::PAD)
    }

    #[test]
    fn edges_belong_to_a_region() {
        let rect = placed(Shape::Rect {
            x: 0.26,
            y: 0.1,
            w: 0.22,
            h: 0.5,
        });
        assert!(rect.contains([48.0, 8.0], 0.0));
        assert!(!rect.contains([48.01, 8.0], 0.0));
        let circle = placed(Shape::Circle {
            x: 0.5,
            y: 0.5,
            r: 0.25,
        });
        assert!(
            circle.contains([70.0, 40.0], 0.0),
            "a share of the shorter side"
        );
        assert!(!circle.contains([70.1, 40.0], 0.0));
    }

    #[test]
    fn reach_is_a_distance_from_the_outline() {
        let l_shape = placed(Shape::Polygon(vec![
            [0.0, 0.0],
            [0.4, 0.0],
            [0.4, 0.2],
            [0.2, 0.2],
            [0.2, 0.6],
            [0.0, 0.6],
        ]));
        assert!(l_shape.contains([30.0, 10.0], 0.0));
        assert!(!l_shape.contains([30.0, 30.0], 0.0), "the notch is outside");
        assert!((l_shape.distance_mm([30.0, 30.0]) - 10.0).abs() < 1e-9);
        assert!(
            l_shape.contains([30.0, 20.0], 0.05),
            "4 mm from the notch's foot"
        );
        let ellipse = placed(Shape::Ellipse {
            x: 0.5,
            y: 0.5,
            w: 0.4,
            h: 0.5,
        });
        assert!((ellipse.distance_mm([80.0, 40.0]) - 10.0).abs() < 1e-9);
        assert_eq!(ellipse.distance_mm([50.0, 21.0]), 0.0);
    }
}
