//! The level as a picture: sky, hills, ground of gel, coins, the flag, and a drop of gel that jumps.
//!
//! Everything is drawn with plain shapes, in two sets of colours: an evening and a morning.

use egui::epaint::{CubicBezierShape, Mesh};
use egui::{
    Align2, Color32, CornerRadius, FontId, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, Vec2,
    pos2, vec2,
};

use super::level::{TILE, Tile};
use super::physics::SIZE;
use super::{Practice, Stage};

/// The player stands at this share of the width from the left.
const AHEAD: f64 = 0.36;
/// Rows of the level, and columns of it, that are always seen.
const ROWS_SEEN: f64 = 13.0;
const COLUMNS_SEEN: f64 = 21.0;
/// A coin turns once in so many steps.
const TURN_STEPS: f64 = 110.0;
/// Taller and narrower by so much at most, while it rises or falls.
const STRETCH: f32 = 0.22;

/// Colours of a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Colours {
    sky: [Color32; 2],
    hills: [Color32; 2],
    ground: Color32,
    turf: Color32,
    block: Color32,
    block_edge: Color32,
    coin: Color32,
    coin_edge: Color32,
    pub(super) drop: Color32,
    drop_light: Color32,
    eye: Color32,
    flag: Color32,
    pub(super) ink: Color32,
}

const EVENING: Colours = Colours {
    sky: [
        Color32::from_rgb(0x1b, 0x1f, 0x3b),
        Color32::from_rgb(0x4a, 0x3f, 0x6b),
    ],
    hills: [
        Color32::from_rgb(0x33, 0x33, 0x5c),
        Color32::from_rgb(0x28, 0x2a, 0x4d),
    ],
    ground: Color32::from_rgb(0x17, 0x2a, 0x3a),
    turf: Color32::from_rgb(0x2f, 0x9c, 0x95),
    block: Color32::from_rgb(0x7a, 0x5c, 0x8e),
    block_edge: Color32::from_rgb(0xa9, 0x8b, 0xbd),
    coin: Color32::from_rgb(0xff, 0xd1, 0x66),
    coin_edge: Color32::from_rgb(0xd9, 0x93, 0x2a),
    drop: Color32::from_rgb(0xff, 0x8f, 0x5c),
    drop_light: Color32::from_rgb(0xff, 0xc7, 0xa1),
    eye: Color32::from_rgb(0x1a, 0x14, 0x20),
    flag: Color32::from_rgb(0x6f, 0xe0, 0xb5),
    ink: Color32::from_rgb(0xf4, 0xf1, 0xff),
};

const MORNING: Colours = Colours {
    sky: [
        Color32::from_rgb(0xa9, 0xd8, 0xf0),
        Color32::from_rgb(0xf6, 0xec, 0xdc),
    ],
    hills: [
        Color32::from_rgb(0xbf, 0xd9, 0xd4),
        Color32::from_rgb(0x9f, 0xc7, 0xbf),
    ],
    ground: Color32::from_rgb(0x5b, 0x4a, 0x42),
    turf: Color32::from_rgb(0x3f, 0x9d, 0x6d),
    block: Color32::from_rgb(0xc9, 0x7b, 0x4a),
    block_edge: Color32::from_rgb(0x8d, 0x4f, 0x2b),
    coin: Color32::from_rgb(0xff, 0xc2, 0x2e),
    coin_edge: Color32::from_rgb(0xa8, 0x6a, 0x00),
    drop: Color32::from_rgb(0xd8, 0x43, 0x5f),
    drop_light: Color32::from_rgb(0xf5, 0x9c, 0xa9),
    eye: Color32::from_rgb(0x2a, 0x12, 0x1a),
    flag: Color32::from_rgb(0x1f, 0x7a, 0x8c),
    ink: Color32::from_rgb(0x23, 0x1f, 0x2e),
};

pub(super) fn colours(dark: bool) -> Colours {
    if dark { EVENING } else { MORNING }
}

/// Level to window.
struct Camera {
    left: f64,
    scale: f64,
    room: Rect,
}

impl Camera {
    fn new(practice: &Practice, room: Rect) -> Self {
        let scale = (f64::from(room.height()) / (ROWS_SEEN * TILE))
            .min(f64::from(room.width()) / (COLUMNS_SEEN * TILE))
            .max(1e-3);
        let seen = f64::from(room.width()) / scale;
        let most = (practice.level().width() - seen).max(0.0);
        Self {
            left: (practice.body().place[0] - AHEAD * seen).clamp(0.0, most),
            scale,
            room,
        }
    }

    fn at(&self, [x, y]: [f64; 2]) -> Pos2 {
        pos2(
            self.room.left() + ((x - self.left) * self.scale) as f32,
            self.room.bottom() - (y * self.scale) as f32,
        )
    }

    fn long(&self, px: f64) -> f32 {
        (px * self.scale) as f32
    }

    fn rect(&self, low: [f64; 2], high: [f64; 2]) -> Rect {
        Rect::from_two_pos(self.at(low), self.at(high))
    }
}

/// Draws the level into a room.
pub(super) fn draw(painter: &Painter, room: Rect, practice: &Practice, dark: bool) {
    let painter = painter.with_clip_rect(room.intersect(painter.clip_rect()));
    let colours = colours(dark);
    let camera = Camera::new(practice, room);
    sky(&painter, room, &colours);
    hills(&painter, &camera, &colours);
    flag(&painter, &camera, practice, &colours);
    tiles(&painter, &camera, practice, &colours);
    coins(&painter, &camera, practice, &colours);
    for (index, place) in practice.trail().enumerate() {
        let share = index as f32 / practice.trail().len() as f32;
        let middle = camera.at([place[0], place[1] + SIZE[1] / 2.0]);
        painter.circle_filled(
            middle,
            camera.long(1.0 + 1.2 * f64::from(share)),
            colours.drop.gamma_multiply(0.15 + 0.35 * share),
        );
    }
    last_jump(&painter, &camera, practice, &colours);
    player(&painter, &camera, practice, &colours);
}

fn sky(painter: &Painter, room: Rect, colours: &Colours) {
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

/// Two rows of round hills, the far one slower.
fn hills(painter: &Painter, camera: &Camera, colours: &Colours) {
    // They end at the ground: a gap is a gap down to the bottom.
    let mut above = camera.room;
    above.max.y = camera.at([0.0, 2.0 * TILE]).y;
    let painter = painter.with_clip_rect(above.intersect(painter.clip_rect()));
    for (colour, pace, apart, radius) in [
        (colours.hills[0], 0.25, 170.0, 105.0),
        (colours.hills[1], 0.5, 120.0, 66.0),
    ] {
        let seen = f64::from(camera.room.width()) / camera.scale;
        let shift = camera.left * pace;
        let first = ((shift - radius) / apart).floor() as i64;
        let last = ((shift + seen + radius) / apart).ceil() as i64;
        for hill in first..=last {
            // Every hill its own size, the same each time.
            let wave = 0.8 + 0.2 * libm::sin(hill as f64 * 2.4);
            let middle = camera.at([
                camera.left + hill as f64 * apart - shift,
                1.2 * TILE - 0.25 * radius,
            ]);
            painter.circle_filled(middle, camera.long(radius * wave), colour);
        }
    }
}

fn tiles(painter: &Painter, camera: &Camera, practice: &Practice, colours: &Colours) {
    let level = practice.level();
    let seen = f64::from(camera.room.width()) / camera.scale;
    let columns = (camera.left / TILE).floor() as i64..=((camera.left + seen) / TILE).ceil() as i64;
    let rows = 0..(level.height() / TILE) as i64;
    for column in columns {
        for row in rows.clone() {
            let low = [column as f64 * TILE, row as f64 * TILE];
            let high = [low[0] + TILE, low[1] + TILE];
            let rect = camera.rect(low, high);
            match level.tile(column, row) {
                Tile::Air => {}
                Tile::Ground => {
                    let is_top = level.tile(column, row + 1) == Tile::Air;
                    // A little wider: no seams between tiles; round corners of the turf stay free.
                    let mut earth = rect.expand2(vec2(0.6, 0.6));
                    if is_top {
                        earth.min.y = rect.top() + camera.long(4.5);
                    }
                    painter.rect_filled(earth, 0.0, colours.ground);
                    if is_top {
                        let side = |other: i64| level.tile(other, row) == Tile::Air;
                        let round = (camera.long(5.0)).min(255.0) as u8;
                        let corners = CornerRadius {
                            nw: if side(column - 1) { round } else { 0 },
                            ne: if side(column + 1) { round } else { 0 },
                            sw: 0,
                            se: 0,
                        };
                        let turf = Rect::from_min_max(
                            rect.left_top() - vec2(0.6, 0.0),
                            pos2(rect.right() + 0.6, rect.top() + camera.long(5.0)),
                        );
                        painter.rect_filled(turf, corners, colours.turf);
                    }
                }
                Tile::Block => {
                    let rect = rect.shrink(camera.long(0.6));
                    let round = camera.long(3.5);
                    painter.rect(
                        rect,
                        round,
                        colours.block,
                        Stroke::new(camera.long(1.2), colours.block_edge),
                        StrokeKind::Inside,
                    );
                }
            }
        }
    }
}

fn coins(painter: &Painter, camera: &Camera, practice: &Practice, colours: &Colours) {
    for (index, (coin, taken)) in practice
        .level()
        .coins
        .iter()
        .zip(practice.taken())
        .enumerate()
    {
        if *taken {
            continue;
        }
        let phase = practice.clock() as f64 / TURN_STEPS + index as f64 * 0.13;
        let wide = 0.35 + 0.65 * libm::fabs(libm::cos(phase * core::f64::consts::PI));
        let size = vec2(camera.long(5.0 * wide), camera.long(5.0));
        let middle = camera.at(*coin);
        painter.add(Shape::ellipse_filled(middle, size, colours.coin));
        painter.add(Shape::ellipse_stroke(
            middle,
            size,
            Stroke::new(camera.long(1.2), colours.coin_edge),
        ));
    }
}

fn flag(painter: &Painter, camera: &Camera, practice: &Practice, colours: &Colours) {
    let [x, y] = practice.level().flag;
    let (foot, top) = (camera.at([x, y]), camera.at([x, y + 5.0 * TILE]));
    painter.line_segment([foot, top], Stroke::new(camera.long(2.0), colours.ink));
    painter.circle_filled(top, camera.long(2.6), colours.coin);
    let wave = camera.long(3.0) * (practice.clock() as f32 / 14.0).sin();
    let [long, high] = [camera.long(30.0), camera.long(16.0)];
    let start = top + vec2(camera.long(1.0), camera.long(3.0));
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
    // Upper and lower edge as strips: the cloth waves and stays whole.
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

/// Height and length of the last jump, where it happened.
fn last_jump(painter: &Painter, camera: &Camera, practice: &Practice, colours: &Colours) {
    let Some(jump) = practice.jumps().next_back() else {
        return;
    };
    let body = practice.body();
    if body.on_ground || jump.height_px < 2.0 {
        return;
    }
    let x = body.place[0] - 22.0;
    let (low, high) = (
        camera.at([x, body.took_off]),
        camera.at([x, body.took_off + jump.height_px]),
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

/// The player: a drop of gel, flatter when it lands and longer when it flies.
fn player(painter: &Painter, camera: &Camera, practice: &Practice, colours: &Colours) {
    let body = practice.body();
    let [speed, climb] = body.velocity;
    let stretch = STRETCH * (climb.abs() as f32 / 5.0).min(1.0);
    let lean = camera.long(1.6 * speed);
    let size = vec2(
        camera.long(SIZE[0] / 2.0 + 1.5) * (1.0 - stretch * 0.7),
        camera.long(SIZE[1] / 2.0 + 0.5) * (1.0 + stretch),
    );
    let foot = camera.at(body.place);
    let middle = foot - vec2(0.0, size.y);
    if body.on_ground {
        let shadow = vec2(size.x * 1.05, camera.long(1.6));
        painter.add(Shape::ellipse_filled(
            foot,
            shadow,
            Color32::from_black_alpha(50),
        ));
    }
    painter.add(Shape::ellipse_filled(middle, size, colours.drop));
    // The tip of the drop bends against the way it goes.
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
    let look = size.x * if speed < -0.1 { -0.22 } else { 0.22 };
    for side in [-1.0, 1.0] {
        let eye = middle + vec2(look + side * size.x * 0.3, -size.y * 0.05);
        let blinks = practice.clock() % 190 < 6;
        let open = if blinks { 0.2 } else { 1.0 };
        let round = vec2(size.x * 0.13, size.y * 0.2 * open);
        painter.add(Shape::ellipse_filled(eye, round, colours.eye));
    }
    if matches!(practice.stage(), Stage::Done { .. }) {
        let smile = [-0.3, 0.0, 0.3].map(|share| {
            let down = if share == 0.0 { 0.42 } else { 0.28 };
            middle + vec2(look + share * size.x, size.y * down)
        });
        painter.add(Shape::line(
            smile.to_vec(),
            Stroke::new(camera.long(1.2), colours.eye),
        ));
    }
}
