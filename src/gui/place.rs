//! Where the pad lies on the screen: millimetres as the instrument counts them, as the player sees them (mirrored, turned),
//! and points of the window.

use egui::{Pos2, Rect, Vec2};

use crate::profile::{Mirror, Rotation, Settings};
use crate::types::PointMm;

/// The pad in a rectangle of the window.
#[derive(Clone, Debug)]
pub struct Place {
    /// Where it is drawn.
    pub rect: Rect,
    /// Its size as the instrument counts, mm.
    pub pad_mm: [f64; 2],
    /// Its size as the player sees it, mm.
    pub seen_mm: [f64; 2],
    mirror: Mirror,
    rotate: Rotation,
}

impl Place {
    /// The largest picture of a pad that fits into a room, in its middle.
    #[must_use]
    pub fn fit(room: Rect, pad_mm: [f64; 2], settings: &Settings) -> Self {
        let seen_mm = settings.seen_size_mm(pad_mm);
        let [w, h] = seen_mm.map(|mm| mm as f32);
        let scale = (room.width() / w).min(room.height() / h).max(0.0);
        Self {
            rect: Rect::from_center_size(room.center(), Vec2::new(w * scale, h * scale)),
            pad_mm,
            seen_mm,
            mirror: settings.mirror,
            rotate: settings.rotate,
        }
    }

    /// Points of the window for a millimetre.
    #[must_use]
    pub fn points_per_mm(&self) -> f32 {
        self.rect.width() / self.seen_mm[0] as f32
    }

    /// A place that the player sees, on the window.
    #[must_use]
    pub fn of_seen(&self, [x, y]: PointMm) -> Pos2 {
        let scale = self.points_per_mm();
        Pos2::new(
            self.rect.left() + x as f32 * scale,
            self.rect.bottom() - y as f32 * scale,
        )
    }

    /// A place as the instrument counts, on the window.
    #[must_use]
    pub fn of_pad(&self, point: PointMm) -> Pos2 {
        self.of_seen(self.seen(point))
    }

    /// What the player sees at a point of the window, mm.
    #[must_use]
    pub fn to_seen(&self, point: Pos2) -> PointMm {
        let scale = f64::from(self.points_per_mm());
        [
            f64::from(point.x - self.rect.left()) / scale,
            f64::from(self.rect.bottom() - point.y) / scale,
        ]
    }

    /// What the instrument has at a point of the window, mm.
    #[must_use]
    pub fn to_pad(&self, point: Pos2) -> PointMm {
        self.unseen(self.to_seen(point))
    }

    /// Where the player sees a place; see [`Settings::seen`].
    fn seen(&self, [x, y]: PointMm) -> PointMm {
        let [width, height] = self.pad_mm;
        let [x, y] = self.mirrored([x, y]);
        match self.rotate {
            Rotation::None => [x, y],
            Rotation::Quarter => [height - y, x],
            Rotation::Half => [width - x, height - y],
            Rotation::ThreeQuarters => [y, width - x],
        }
    }

    /// The place that the player sees there: undoes [`Settings::seen`].
    fn unseen(&self, [x, y]: PointMm) -> PointMm {
        let [width, height] = self.pad_mm;
        let turned = match self.rotate {
            Rotation::None => [x, y],
            Rotation::Quarter => [y, height - x],
            Rotation::Half => [width - x, height - y],
            Rotation::ThreeQuarters => [width - y, x],
        };
        self.mirrored(turned)
    }

    fn mirrored(&self, [x, y]: PointMm) -> PointMm {
        let [width, height] = self.pad_mm;
        let (across, along) = match self.mirror {
            Mirror::None => (false, false),
            Mirror::Horizontal => (true, false),
            Mirror::Vertical => (false, true),
            Mirror::Both => (true, true),
        };
        [
            if across { width - x } else { x },
            if along { height - y } else { y },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::still;
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
        fn what_is_pressed_on_the_screen_is_where_it_is_seen(
            m in 0..4usize, r in 0..4usize, x in 0.0..120.0f64, y in 0.0..80.0f64,
        ) {
            let settings = settings(MIRRORS[m], ROTATIONS[r]);
            let pad_mm = [120.0, 80.0];
            let room = Rect::from_min_size(Pos2::new(10.0, 20.0), Vec2::new(600.0, 500.0));
            let place = Place::fit(room, pad_mm, &settings);
            // The engine's own word for what the player sees.
            let seen = settings.seen([x, y], pad_mm);
            let shown = place.of_pad([x, y]);
            prop_assert!((place.of_seen(seen) - shown).length() < 1e-3);
            prop_assert!(place.rect.expand(1e-3).contains(shown));
            let [back_x, back_y] = place.to_pad(shown);
            prop_assert!((back_x - x).abs() < 1e-3 && (back_y - y).abs() < 1e-3);
        }
    }
}
