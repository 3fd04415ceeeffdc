//! The outer edge of the conducting layer and distances along it.

use std::f64::consts::PI;

use crate::types::PointMm;

/// A rectangle or a circle whose bounding box has its bottom-left corner at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// Sides along x and y.
    Rectangle {
        /// Along x, mm.
        width_mm: f64,
        /// Along y, mm.
        height_mm: f64,
    },
    /// Centre at (radius, radius).
    Circle {
        /// Radius, mm.
        radius_mm: f64,
    },
}

impl Outline {
    /// Width and height of the bounding box, mm.
    #[must_use]
    pub fn size_mm(&self) -> [f64; 2] {
        match *self {
            Self::Rectangle {
                width_mm,
                height_mm,
            } => [width_mm, height_mm],
            Self::Circle { radius_mm } => [2.0 * radius_mm; 2],
        }
    }

    /// Length of the edge, mm.
    #[must_use]
    pub fn perimeter_mm(&self) -> f64 {
        match *self {
            Self::Rectangle {
                width_mm,
                height_mm,
            } => 2.0 * (width_mm + height_mm),
            Self::Circle { radius_mm } => 2.0 * PI * radius_mm,
        }
    }

    /// Whether a point lies inside or on the edge.
    #[must_use]
    pub fn contains(&self, [x, y]: PointMm) -> bool {
        match *self {
            Self::Rectangle {
                width_mm,
                height_mm,
            } => (0.0..=width_mm).contains(&x) && (0.0..=height_mm).contains(&y),
            Self::Circle { radius_mm } => libm::hypot(x - radius_mm, y - radius_mm) <= radius_mm,
        }
    }

    /// The point at a distance along the edge, counter-clockwise: from the bottom-left corner of a
    /// rectangle, from the rightmost point of a circle.
    #[must_use]
    pub fn point_at(&self, along_mm: f64) -> PointMm {
        let s = along_mm.rem_euclid(self.perimeter_mm());
        match *self {
            Self::Rectangle {
                width_mm: w,
                height_mm: h,
            } => {
                if s <= w {
                    [s, 0.0]
                } else if s <= w + h {
                    [w, s - w]
                } else if s <= 2.0 * w + h {
                    [2.0 * w + h - s, h]
                } else {
                    [0.0, 2.0 * (w + h) - s]
                }
            }
            Self::Circle { radius_mm: r } => {
                let angle = s / r;
                [r + r * libm::cos(angle), r + r * libm::sin(angle)]
            }
        }
    }

    /// The distance along the edge of a point that lies on it to within 0.01 mm.
    #[must_use]
    pub fn distance_along(&self, [x, y]: PointMm) -> Option<f64> {
        const ON_EDGE_MM: f64 = 0.01;
        let near = |a: f64, b: f64| (a - b).abs() <= ON_EDGE_MM;
        match *self {
            Self::Rectangle {
                width_mm: w,
                height_mm: h,
            } => {
                let on_x = (-ON_EDGE_MM..=w + ON_EDGE_MM).contains(&x);
                let on_y = (-ON_EDGE_MM..=h + ON_EDGE_MM).contains(&y);
                // Distance from each side, and position along the edge there: near a corner two sides are in reach, and
                // the nearer one counts.
                [
                    (y.abs(), on_x, x),
                    ((x - w).abs(), on_y, w + y),
                    ((y - h).abs(), on_x, 2.0 * w + h - x),
                    (x.abs(), on_y, 2.0 * (w + h) - y),
                ]
                .into_iter()
                .filter(|(off, within, _)| *within && *off <= ON_EDGE_MM)
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .map(|(_, _, along)| along)
            }
            Self::Circle { radius_mm: r } => {
                let (dx, dy) = (x - r, y - r);
                near(libm::hypot(dx, dy), r).then(|| libm::atan2(dy, dx).rem_euclid(2.0 * PI) * r)
            }
        }
    }

    /// Distances of the corners along the edge.
    #[must_use]
    pub fn corners_mm(&self) -> Vec<f64> {
        match *self {
            Self::Rectangle {
                width_mm: w,
                height_mm: h,
            } => vec![0.0, w, w + h, 2.0 * w + h],
            Self::Circle { .. } => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn near_a_corner_the_nearer_side_counts() {
        let outline = Outline::Rectangle {
            width_mm: 80.0,
            height_mm: 30.0,
        };
        assert_eq!(outline.distance_along([0.0, 29.995]), Some(190.005));
        assert_eq!(outline.distance_along([0.005, 30.0]), Some(189.995));
    }

    proptest! {
        #[test]
        fn a_place_on_the_edge_is_found_again(share in 0.0..1.0f64, circle: bool) {
            let outline = if circle {
                Outline::Circle { radius_mm: 40.0 }
            } else {
                Outline::Rectangle { width_mm: 80.0, height_mm: 30.0 }
            };
            let along = share * outline.perimeter_mm();
            let found = outline.distance_along(outline.point_at(along)).expect("on the edge");
            let gap = (found - along).abs();
            prop_assert!(gap.min(outline.perimeter_mm() - gap) < 1e-9);
        }
    }
}
