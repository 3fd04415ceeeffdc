//! The player, and the scale beside a jump.

use egui::{Align2, Color32, FontId, Painter, Pos2, Shape, Stroke, Vec2, vec2};

use super::camera::Camera;
use super::colours::Colours;
use crate::gui::practice::game::{Practice, RunStage};
use crate::gui::practice::physics::SIZE;

/// The player is at most this much taller and narrower in the air.
const STRETCH: f32 = 0.22;

/// Height of the jump and length of its press, beside the player in the air.
pub(super) fn draw_jump_scale(
    painter: &Painter,
    camera: &Camera,
    practice: &Practice,
    colours: &Colours,
) {
    let Some(jump) = practice.jumps().next_back() else {
        return;
    };
    let body = &practice.body;
    if body.on_ground || jump.height_px < 2.0 {
        return;
    }
    let x = body.place[0] - 22.0;
    let (low, high) = (
        camera.at([x, body.jumped_from]),
        camera.at([x, body.jumped_from + jump.height_px]),
    );
    let stroke = Stroke::new(1.5, colours.ink.gamma_multiply(0.8));
    painter.line_segment([low, high], stroke);
    for end in [low, high] {
        painter.line_segment([end - vec2(5.0, 0.0), end + vec2(5.0, 0.0)], stroke);
    }
    painter.text(
        high - vec2(8.0, 0.0),
        Align2::RIGHT_CENTER,
        format!("{:.0} ms", jump.held_ms),
        FontId::proportional(14.0),
        colours.ink,
    );
}

/// The player: a drop of gel that stretches with its vertical speed.
pub(super) fn draw_player(
    painter: &Painter,
    camera: &Camera,
    practice: &Practice,
    colours: &Colours,
) {
    let body = &practice.body;
    let [speed, climb] = body.velocity;
    let stretch = STRETCH * (climb.abs() as f32 / 5.0).min(1.0);
    let lean = camera.points(1.6 * speed);
    let size = vec2(
        camera.points(SIZE[0] / 2.0 + 1.5) * (1.0 - stretch * 0.7),
        camera.points(SIZE[1] / 2.0 + 0.5) * (1.0 + stretch),
    );
    let foot = camera.at(body.place);
    let middle = foot - vec2(0.0, size.y);
    if body.on_ground {
        let shadow = vec2(size.x * 1.05, camera.points(1.6));
        painter.add(Shape::ellipse_filled(
            foot,
            shadow,
            Color32::from_black_alpha(50),
        ));
    }
    painter.add(Shape::ellipse_filled(middle, size, colours.drop));
    // The tip of the drop bends backwards.
    let tip = middle + vec2(-lean, -size.y * 1.35);
    let shoulder = |side: f32| middle + vec2(side * size.x * 0.72, -size.y * 0.62);
    painter.add(Shape::convex_polygon(
        vec![shoulder(-1.0), tip, shoulder(1.0)],
        colours.drop,
        Stroke::NONE,
    ));
    painter.add(Shape::ellipse_filled(
        middle + vec2(-size.x * 0.36, -size.y * 0.3),
        Vec2::new(size.x * 0.2, size.y * 0.26),
        colours.drop_light,
    ));
    draw_face(painter, camera, practice, colours, middle, size);
}

/// Eyes that look ahead and blink; a smile after the end.
fn draw_face(
    painter: &Painter,
    camera: &Camera,
    practice: &Practice,
    colours: &Colours,
    middle: Pos2,
    size: Vec2,
) {
    let look = size.x
        * if practice.body.velocity[0] < -0.1 {
            -0.22
        } else {
            0.22
        };
    for side in [-1.0, 1.0] {
        let eye = middle + vec2(look + side * size.x * 0.3, -size.y * 0.05);
        let is_blinking = practice.total_steps % 190 < 6;
        let open = if is_blinking { 0.2 } else { 1.0 };
        let round = vec2(size.x * 0.13, size.y * 0.2 * open);
        painter.add(Shape::ellipse_filled(eye, round, colours.eye));
    }
    if matches!(practice.stage(), RunStage::Done { .. }) {
        let smile = [-0.3, 0.0, 0.3].map(|share| {
            let down = if share == 0.0 { 0.42 } else { 0.28 };
            middle + vec2(look + share * size.x, size.y * down)
        });
        painter.add(Shape::line(
            smile.to_vec(),
            Stroke::new(camera.points(1.2), colours.eye),
        ));
    }
}
