//! The visible part of the level.

use egui::{Pos2, Rect, pos2};

use crate::gui::practice::game::Practice;
use crate::gui::practice::level::TILE;

/// The player stays at this share of the width from the left.
const PLAYER_AT: f64 = 0.36;
/// Rows and columns of the level that are always visible.
const MIN_ROWS: f64 = 13.0;
const MIN_COLUMNS: f64 = 21.0;

/// Maps the level to the window; follows the player.
pub(super) struct Camera {
    /// Left edge, px of the level.
    pub(super) left: f64,
    /// Points per px.
    pub(super) scale: f64,
    pub(super) room: Rect,
}

impl Camera {
    pub(super) fn new(practice: &Practice, room: Rect) -> Self {
        let scale = (f64::from(room.height()) / (MIN_ROWS * TILE))
            .min(f64::from(room.width()) / (MIN_COLUMNS * TILE))
            .max(1e-3);
        let width = f64::from(room.width()) / scale;
        let last = (practice.level.width() - width).max(0.0);
        Self {
            left: (practice.body.place[0] - PLAYER_AT * width).clamp(0.0, last),
            scale,
            room,
        }
    }

    /// A point of the level on the window.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> Pos2 {
        pos2(
            self.room.left() + ((x - self.left) * self.scale) as f32,
            self.room.bottom() - (y * self.scale) as f32,
        )
    }

    /// A length of the level in points.
    pub(super) fn points(&self, px: f64) -> f32 {
        (px * self.scale) as f32
    }

    pub(super) fn rect(&self, low: [f64; 2], high: [f64; 2]) -> Rect {
        Rect::from_two_pos(self.at(low), self.at(high))
    }

    /// Width of the visible part of the level, px.
    pub(super) fn visible_px(&self) -> f64 {
        f64::from(self.room.width()) / self.scale
    }
}
