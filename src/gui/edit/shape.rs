//! Moving and resizing a region, in fractions of the pad. A region never leaves the pad.

use crate::profile::Shape;

/// Smallest width and height of a region, fraction of the pad.
const SMALLEST: f64 = 0.03;

/// The part of a region that is dragged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grip {
    /// The whole region.
    Whole,
    /// An edge or a corner: left -1 or right 1, bottom -1 or top 1, 0 for neither.
    Edge(i8, i8),
}

/// The part of a region at a point: an edge of its bounding box within `near`, else the whole. Fractions of the pad.
#[must_use]
pub fn grip_at([x, y]: [f64; 2], low: [f64; 2], high: [f64; 2], near: [f64; 2]) -> Option<Grip> {
    let inside =
        |value: f64, low: f64, high: f64, near: f64| (low - near..=high + near).contains(&value);
    if !inside(x, low[0], high[0], near[0]) || !inside(y, low[1], high[1], near[1]) {
        return None;
    }
    let edge = |value: f64, low: f64, high: f64, near: f64| {
        // The middle of a small region still moves it.
        let near = near.min((high - low) / 4.0);
        if value <= low + near {
            -1
        } else if value >= high - near {
            1
        } else {
            0
        }
    };
    Some(
        match (
            edge(x, low[0], high[0], near[0]),
            edge(y, low[1], high[1], near[1]),
        ) {
            (0, 0) => Grip::Whole,
            (dx, dy) => Grip::Edge(dx, dy),
        },
    )
}

/// The numbers of a shape after a drag by a fraction of the pad; none for polygons.
#[must_use]
pub fn dragged(shape: &Shape, grip: Grip, [dx, dy]: [f64; 2]) -> Option<Vec<(&'static str, f64)>> {
    match (shape, grip) {
        (Shape::Rect { x, y, w, h }, Grip::Whole) => Some(vec![
            ("x", (x + dx).clamp(0.0, 1.0 - w)),
            ("y", (y + dy).clamp(0.0, 1.0 - h)),
        ]),
        (Shape::Rect { x, y, w, h }, Grip::Edge(ex, ey)) => {
            let (x, w) = stretched(*x, *w, ex, dx);
            let (y, h) = stretched(*y, *h, ey, dy);
            Some(vec![("x", x), ("y", y), ("w", w), ("h", h)])
        }
        (Shape::Ellipse { x, y, .. } | Shape::Circle { x, y, .. }, Grip::Whole) => Some(vec![
            ("x", (x + dx).clamp(0.0, 1.0)),
            ("y", (y + dy).clamp(0.0, 1.0)),
        ]),
        (Shape::Ellipse { w, h, .. }, Grip::Edge(ex, ey)) => Some(vec![
            ("w", (w + 2.0 * dx * f64::from(ex)).clamp(SMALLEST, 1.0)),
            ("h", (h + 2.0 * dy * f64::from(ey)).clamp(SMALLEST, 1.0)),
        ]),
        (Shape::Circle { r, .. }, Grip::Edge(ex, ey)) => {
            let outwards = if ex == 0 {
                dy * f64::from(ey)
            } else {
                dx * f64::from(ex)
            };
            Some(vec![("r", (r + outwards).clamp(SMALLEST / 2.0, 0.5))])
        }
        (Shape::Polygon(_), _) => None,
    }
}

/// Start and length of an interval whose lower (-1) or upper (1) end is dragged.
fn stretched(start: f64, length: f64, edge: i8, by: f64) -> (f64, f64) {
    let end = start + length;
    match edge {
        -1 => {
            let start = (start + by).clamp(0.0, end - SMALLEST);
            (start, end - start)
        }
        1 => (start, (end + by).clamp(start + SMALLEST, 1.0) - start),
        _ => (start, length),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_dragged_rectangle_stays_on_the_pad(
            x in 0.0..0.9f64, y in 0.0..0.9f64, w in 0.05..0.5f64, h in 0.05..0.5f64,
            dx in -2.0..2.0f64, dy in -2.0..2.0f64, ex in -1..=1i8, ey in -1..=1i8,
        ) {
            let (w, h) = (w.min(1.0 - x), h.min(1.0 - y));
            let shape = Shape::Rect { x, y, w, h };
            let grip = if ex == 0 && ey == 0 { Grip::Whole } else { Grip::Edge(ex, ey) };
            let numbers = dragged(&shape, grip, [dx, dy]).expect("a rectangle");
            let get = |key: &str, old: f64| {
                numbers.iter().find(|(k, _)| *k == key).map_or(old, |(_, n)| *n)
            };
            let (x, y, w, h) = (get("x", x), get("y", y), get("w", w), get("h", h));
            prop_assert!(x >= 0.0 && y >= 0.0 && x + w <= 1.0 + 1e-9 && y + h <= 1.0 + 1e-9);
            prop_assert!(w >= SMALLEST - 1e-9 && h >= SMALLEST - 1e-9);
        }
    }

    #[test]
    fn the_opposite_edge_stays() {
        let shape = Shape::Rect {
            x: 0.2,
            y: 0.2,
            w: 0.4,
            h: 0.4,
        };
        let numbers = dragged(&shape, Grip::Edge(-1, 0), [0.1, 0.3]).expect("a rectangle");
        let rounded: Vec<(&str, f64)> = numbers
            .iter()
            .map(|(key, number)| (*key, (number * 1e6).round() / 1e6))
            .collect();
        assert_eq!(rounded, [("x", 0.3), ("y", 0.2), ("w", 0.3), ("h", 0.4)]);
    }

    #[test]
    fn corners_edges_and_the_middle_are_different_grips() {
        let grip = |x, y| grip_at([x, y], [0.2, 0.2], [0.6, 0.6], [0.05, 0.05]);
        assert_eq!(grip(0.4, 0.4), Some(Grip::Whole));
        assert_eq!(grip(0.21, 0.4), Some(Grip::Edge(-1, 0)));
        assert_eq!(grip(0.59, 0.61), Some(Grip::Edge(1, 1)));
        assert_eq!(grip(0.1, 0.4), None);
    }
}
