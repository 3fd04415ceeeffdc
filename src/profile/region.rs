//! A part of the pad, in shares of its width and height.

use crate::types::PointMm;

/// The outline of a region; all numbers 0..1 of the pad, origin at the bottom-left.
#[derive(Clone, Copy, Debug, PartialEq)]
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
}

/// A named part of the pad.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Its name.
    pub name: String,
    /// Where it lies.
    pub shape: Shape,
}

impl Region {
    /// Whether a place on a pad of a size lies in it, edges included.
    #[must_use]
    pub fn contains(&self, [px, py]: PointMm, [width, height]: [f64; 2]) -> bool {
        match self.shape {
            Shape::Rect { x, y, w, h } => {
                let (u, v) = (px / width, py / height);
                (x..=x + w).contains(&u) && (y..=y + h).contains(&v)
            }
            Shape::Circle { x, y, r } => {
                let (dx, dy) = (px - x * width, py - y * height);
                let radius = r * width.min(height);
                dx * dx + dy * dy <= radius * radius
            }
        }
    }

    /// Its middle on a pad of a size, mm.
    #[must_use]
    pub fn centre_mm(&self, [width, height]: [f64; 2]) -> PointMm {
        match self.shape {
            Shape::Rect { x, y, w, h } => [(x + w / 2.0) * width, (y + h / 2.0) * height],
            Shape::Circle { x, y, .. } => [x * width, y * height],
        }
    }
}
