//! The level as a picture of plain shapes: sky, hills, ground, coins, flag and player.

mod camera;
mod colours;
mod flag;
mod player;

pub(super) use colours::colours;

use egui::epaint::Mesh;
use egui::{CornerRadius, Painter, Rect, Shape, Stroke, StrokeKind, pos2, vec2};

use self::camera::Camera;
use self::colours::Colours;
use self::flag::draw_flag;
use self::player::{draw_jump_scale, draw_player};
use super::game::Practice;
use super::level::{TILE, Tile};
use super::physics::SIZE;

/// Steps of a coin's turn.
const TURN_STEPS: f64 = 110.0;

/// Draws the visible part of the level.
pub(super) fn draw_level(painter: &Painter, room: Rect, practice: &Practice, dark: bool) {
    let painter = painter.with_clip_rect(room.intersect(painter.clip_rect()));
    let colours = colours(dark);
    let camera = Camera::new(practice, room);
    draw_sky(&painter, room, &colours);
    draw_hills(&painter, &camera, &colours);
    draw_flag(&painter, &camera, practice, &colours);
    draw_tiles(&painter, &camera, practice, &colours);
    draw_coins(&painter, &camera, practice, &colours);
    draw_trail(&painter, &camera, practice, &colours);
    draw_jump_scale(&painter, &camera, practice, &colours);
    draw_player(&painter, &camera, practice, &colours);
}

fn draw_trail(painter: &Painter, camera: &Camera, practice: &Practice, colours: &Colours) {
    for (index, place) in practice.trail.iter().enumerate() {
        let share = index as f32 / practice.trail.iter().len() as f32;
        let middle = camera.at([place[0], place[1] + SIZE[1] / 2.0]);
        painter.circle_filled(
            middle,
            camera.points(1.0 + 1.2 * f64::from(share)),
            colours.drop.gamma_multiply(0.15 + 0.35 * share),
        );
    }
}

fn draw_sky(painter: &Painter, room: Rect, colours: &Colours) {
    let mut mesh = Mesh::default();
    for (corner, colour) in [
        (room.left_top(), colours.sky[0]),
        (room.right_top(), colours.sky[0]),
        (room.right_bottom(), colours.sky[1]),
        (room.left_bottom(), colours.sky[1]),
    ] {
        mesh.colored_vertex(corner, colour);
    }
    mesh.add_triangle(0, 1, 2);
    mesh.add_triangle(0, 2, 3);
    painter.add(Shape::mesh(mesh));
}

/// Two rows of hills; the far row moves slower (parallax).
fn draw_hills(painter: &Painter, camera: &Camera, colours: &Colours) {
    // Hills end at the ground: gaps stay free down to the bottom.
    let mut above = camera.room;
    above.max.y = camera.at([0.0, 2.0 * TILE]).y;
    let painter = painter.with_clip_rect(above.intersect(painter.clip_rect()));
    for (colour, pace, distance, radius) in [
        (colours.hills[0], 0.25, 170.0, 105.0),
        (colours.hills[1], 0.5, 120.0, 66.0),
    ] {
        let visible = camera.visible_px();
        let shift = camera.left * pace;
        let first = ((shift - radius) / distance).floor() as i64;
        let last = ((shift + visible + radius) / distance).ceil() as i64;
        for hill in first..=last {
            // Each hill has its own size.
            let wave = 0.8 + 0.2 * libm::sin(hill as f64 * 2.4);
            let middle = camera.at([
                camera.left + hill as f64 * distance - shift,
                1.2 * TILE - 0.25 * radius,
            ]);
            painter.circle_filled(middle, camera.points(radius * wave), colour);
        }
    }
}

fn draw_tiles(painter: &Painter, camera: &Camera, practice: &Practice, colours: &Colours) {
    let level = &practice.level;
    let right = camera.left + camera.visible_px();
    let columns = (camera.left / TILE).floor() as i64..=(right / TILE).ceil() as i64;
    for column in columns {
        for row in 0..(level.height() / TILE) as i64 {
            let low = [column as f64 * TILE, row as f64 * TILE];
            let rect = camera.rect(low, [low[0] + TILE, low[1] + TILE]);
            match level.tile(column, row) {
                Tile::Air => {}
                Tile::Ground => {
                    let is_air = |dx, dy| level.tile(column + dx, row + dy) == Tile::Air;
                    let turf = is_air(0, 1).then(|| [is_air(-1, 0), is_air(1, 0)]);
                    draw_ground(painter, camera, rect, turf, colours);
                }
                Tile::Block => {
                    painter.rect(
                        rect.shrink(camera.points(0.6)),
                        camera.points(3.5),
                        colours.block,
                        Stroke::new(camera.points(1.2), colours.block_edge),
                        StrokeKind::Inside,
                    );
                }
            }
        }
    }
}

/// A tile of ground. `turf`: it is on top, with round corners to the left and right where those are free.
fn draw_ground(
    painter: &Painter,
    camera: &Camera,
    rect: Rect,
    turf: Option<[bool; 2]>,
    colours: &Colours,
) {
    // Slightly larger than a tile: no seams.
    const OVERLAP: f32 = 0.6;
    let mut earth = rect.expand(OVERLAP);
    let Some(free_sides) = turf else {
        painter.rect_filled(earth, 0.0, colours.ground);
        return;
    };
    earth.min.y = rect.top() + camera.points(4.5);
    painter.rect_filled(earth, 0.0, colours.ground);
    let round = camera.points(5.0).min(255.0) as u8;
    let [nw, ne] = free_sides.map(|is_free| if is_free { round } else { 0 });
    let (sw, se) = (0, 0);
    let turf = Rect::from_min_max(
        rect.left_top() - vec2(OVERLAP, 0.0),
        pos2(rect.right() + OVERLAP, rect.top() + camera.points(5.0)),
    );
    painter.rect_filled(turf, CornerRadius { nw, ne, sw, se }, colours.turf);
}

fn draw_coins(painter: &Painter, camera: &Camera, practice: &Practice, colours: &Colours) {
    for (index, (coin, taken)) in practice
        .level
        .coins
        .iter()
        .zip(&practice.coins_taken)
        .enumerate()
    {
        if *taken {
            continue;
        }
        let phase = practice.total_steps as f64 / TURN_STEPS + index as f64 * 0.13;
        let wide = 0.35 + 0.65 * libm::fabs(libm::cos(phase * core::f64::consts::PI));
        let size = vec2(camera.points(5.0 * wide), camera.points(5.0));
        let middle = camera.at(*coin);
        painter.add(Shape::ellipse_filled(middle, size, colours.coin));
        painter.add(Shape::ellipse_stroke(
            middle,
            size,
            Stroke::new(camera.points(1.2), colours.coin_edge),
        ));
    }
}
