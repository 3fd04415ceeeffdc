//! The waving flag at the end.

use egui::epaint::{CubicBezierShape, Mesh};
use egui::{Color32, Painter, Pos2, Shape, Stroke, vec2};

use super::camera::Camera;
use super::colours::Colours;
use crate::gui::practice::game::Practice;
use crate::gui::practice::level::TILE;

pub(super) fn draw_flag(
    painter: &Painter,
    camera: &Camera,
    practice: &Practice,
    colours: &Colours,
) {
    let [x, y] = practice.level.flag;
    let (foot, top) = (camera.at([x, y]), camera.at([x, y + 5.0 * TILE]));
    painter.line_segment([foot, top], Stroke::new(camera.points(2.0), colours.ink));
    painter.circle_filled(top, camera.points(2.6), colours.coin);
    let wave = camera.points(3.0) * (practice.total_steps as f32 / 14.0).sin();
    let [long, high] = [camera.points(30.0), camera.points(16.0)];
    let start = top + vec2(camera.points(1.0), camera.points(3.0));
    let edge = |down: f32| {
        let from = start + vec2(0.0, down);
        CubicBezierShape::from_points_stroke(
            [
                from,
                from + vec2(long * 0.35, wave),
                from + vec2(long * 0.7, -wave),
                from + vec2(long, 0.0),
            ],
            false,
            Color32::TRANSPARENT,
            Stroke::NONE,
        )
        .flatten(Some(0.3))
    };
    // The cloth is a strip between its upper and lower edge.
    let (upper, lower) = (edge(0.0), edge(high));
    let mut mesh = Mesh::default();
    for share in 0..=12 {
        let at = |points: &[Pos2]| points[(share * points.len().saturating_sub(1)) / 12];
        if upper.is_empty() || lower.is_empty() {
            return;
        }
        mesh.colored_vertex(at(&upper), colours.flag);
        mesh.colored_vertex(at(&lower), colours.flag);
        if share > 0 {
            let last = 2 * share as u32;
            mesh.add_triangle(last - 2, last - 1, last);
            mesh.add_triangle(last - 1, last, last + 1);
        }
    }
    painter.add(Shape::mesh(mesh));
}
