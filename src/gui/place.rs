//! Coordinates of the pad on screen: millimetres on the pad, millimetres as the player sees it (mirrored, rotated), and points of
//! the window.

use egui::{Pos2, Rect, Vec2};

use crate::profile::Settings;
use crate::types::PointMm;

/// Maps between the pad, the player's view of it and the window.
#[derive(Clone, Debug)]
pub struct PadTransform {
    /// The rectangle of the pad in the window.
    pub rect: Rect,
    /// Size of the pad, mm.
    pub pad_mm: [f64; 2],
    /// Size as the player sees it, mm: width and height are swapped by a quarter turn.
    pub seen_mm: [f64; 2],
    /// The origin of the pad and its axes in the player's view, mm.
    origin: PointMm,
    x_axis: PointMm,
    y_axis: PointMm,
}

impl PadTransform {
    /// The largest picture of a pad that fits into `room`, centred.
    pub fn fit(room: Rect, pad_mm: [f64; 2], settings: &Settings) -> Self {
        let seen_mm = settings.size_as_player_sees_mm(pad_mm);
        let [w, h] = seen_mm.map(|mm| mm as f32);
        let scale = (room.width() / w).min(room.height() / h).max(0.0);
        let origin = settings.as_player_sees([0.0, 0.0], pad_mm);
        let axis = |unit| {
            let end = settings.as_player_sees(unit, pad_mm);
            [0, 1].map(|i| end[i] - origin[i])
        };
        Self {
            rect: Rect::from_center_size(room.center(), Vec2::new(w * scale, h * scale)),
            pad_mm,
            seen_mm,
            origin,
            x_axis: axis([1.0, 0.0]),
            y_axis: axis([0.0, 1.0]),
        }
    }

    /// Scale, points/mm.
    pub fn points_per_mm(&self) -> f32 {
        self.rect.width() / self.seen_mm[0] as f32
    }

    /// From the player's view (mm) to the window.
    pub fn screen_from_seen(&self, [x, y]: PointMm) -> Pos2 {
        let scale = self.points_per_mm();
        Pos2::new(
            self.rect.left() + x as f32 * scale,
            self.rect.bottom() - y as f32 * scale,
        )
    }

    /// From the pad (mm) to the window.
    pub fn screen_from_pad(&self, point: PointMm) -> Pos2 {
        self.screen_from_seen(self.seen_from_pad(point))
    }

    /// From the window to the player's view, mm.
    pub fn seen_from_screen(&self, point: Pos2) -> PointMm {
        let scale = f64::from(self.points_per_mm());
        [
            f64::from(point.x - self.rect.left()) / scale,
            f64::from(self.rect.bottom() - point.y) / scale,
        ]
    }

    /// From the window to the pad, mm.
    pub fn pad_from_screen(&self, point: Pos2) -> PointMm {
        self.pad_from_seen(self.seen_from_screen(point))
    }

    /// From the pad to the player's view.
    fn seen_from_pad(&self, [x, y]: PointMm) -> PointMm {
        [0, 1].map(|i| self.origin[i] + x * self.x_axis[i] + y * self.y_axis[i])
    }

    /// From the player's view to the pad. The axes are orthonormal, so their transpose is the inverse.
    fn pad_from_seen(&self, seen: PointMm) -> PointMm {
        let [dx, dy] = [0, 1].map(|i| seen[i] - self.origin[i]);
        [self.x_axis, self.y_axis].map(|axis| axis[0] * dx + axis[1] * dy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::still;
    use crate::profile::{Mirror, Rotation};
    use proptest::prelude::*;

    const MIRRORS: [Mirror; 4] = [
        Mirror::None,
        Mirror::Horizontal,
        Mirror::Vertical,
        Mirror::Both,
    ];
    const ROTATIONS: [Rotation; 4] = [
        Rotation::None,
        Rotation::Quarter,
        Rotation::Half,
        Rotation::ThreeQuarters,
    ];

    fn settings(mirror: Mirror, rotate: Rotation) -> Settings {
        let mut settings = still::profile().settings.clone();
        settings.mirror = mirror;
        settings.rotate = rotate;
        settings
    }

    proptest! {
        #[test]
        fn window_and_pad_coordinates_are_inverse_and_agree_with_the_engine(
            m in 0..4usize, r in 0..4usize, x in 0.0..120.0f64, y in 0.0..80.0f64,
        ) {
            let settings = settings(MIRRORS[m], ROTATIONS[r]);
            let pad_mm = [120.0, 80.0];
            let room = Rect::from_min_size(Pos2::new(10.0, 20.0), Vec2::new(600.0, 500.0));
            let place = PadTransform::fit(room, pad_mm, &settings);
            let seen = settings.as_player_sees([x, y], pad_mm);
            let shown = place.screen_from_pad([x, y]);
            prop_assert!((place.screen_from_seen(seen) - shown).length() < 1e-3);
            prop_assert!(place.rect.expand(1e-3).contains(shown));
            let [back_x, back_y] = place.pad_from_screen(shown);
            prop_assert!((back_x - x).abs() < 1e-3 && (back_y - y).abs() < 1e-3);
        }
    }
}
