//! The pad as a picture: conductivity, regions with what they do, touches with their ways.

use egui::epaint::{Mesh, PathShape, PathStroke, Vertex};
use egui::{
    Align2, Color32, ColorImage, FontId, Pos2, Rect, Shape, Stroke, TextureHandle, TextureOptions,
    Ui, Vec2,
};

use super::place::Place;
use super::playing::Playing;
use super::regions::{self, RegionState};
use super::story::Stroke as TouchStroke;
use super::theme;
use crate::pad::Outline;
use crate::profile::Profile;
use crate::types::{Image, NANOS_PER_MS, Nanos, PixelGrid, Touch, heat};

/// The colour scale ends at this relative rise, or at the image's peak if that is higher.
const FULL_SCALE: f32 = 0.3;
/// A higher peak is left again by this share a frame: colours must not flicker.
const SCALE_FALL: f32 = 0.985;
/// A touch draws its way behind it for so long.
const TRAIL_NS: Nanos = 600 * NANOS_PER_MS;
/// Smallest text on the pad, points.
const SMALLEST_TEXT: f32 = 10.0;
/// Room for the scale beside the picture, points.
const SCALE_ROOM: f32 = 54.0;

/// What is drawn besides the image.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// Regions with their names.
    pub regions: bool,
    /// Electrodes with their numbers.
    pub electrodes: bool,
    /// The colour scale.
    pub scale: bool,
}

/// The image as a texture, and its scale.
#[derive(Default)]
pub struct Picture {
    texture: Option<TextureHandle>,
    shown: Option<(u64, Nanos, PixelGrid)>,
    scale: f32,
}

impl Picture {
    /// Draws the pad with a profile's regions into a room; returns where it lies.
    pub fn draw(
        &mut self,
        ui: &Ui,
        room: Rect,
        playing: &Playing,
        profile: &Profile,
        shown: Shown,
    ) -> Place {
        let view = &playing.view;
        let edge = if shown.electrodes { 22.0 } else { 4.0 };
        let mut inner = room.shrink(edge);
        if shown.scale {
            inner.max.x -= SCALE_ROOM;
        }
        let pad_mm = playing.pad.outline.size_mm();
        let place = Place::fit(inner, pad_mm, &profile.settings);
        if place.rect.width() < 8.0 {
            return place;
        }
        self.take(ui, &view.image, view.frames, view.t_ns);
        let painter = ui.painter_at(room);
        self.image(&painter, &place, &view.image.grid);
        outline(&painter, &place, &playing.pad.outline, ui);
        if shown.electrodes {
            electrodes(&painter, &place, playing, ui);
        }
        if shown.regions {
            let states = regions::states(profile, &view.held);
            // Lowest first, so that what lies on top is drawn last.
            for index in (0..states.len()).rev() {
                region(&painter, &place, profile, index, &states[index]);
            }
        }
        for stroke in &playing.story.strokes {
            trail(&painter, &place, stroke, playing.story.now_ns);
        }
        for touch in &view.touches {
            draw_touch(&painter, &place, touch, waited(playing, touch));
        }
        for pinned in playing.fingers.pinned_mm() {
            let at = place.of_pad(pinned) + Vec2::new(0.0, -12.0);
            let font = FontId::proportional(15.0);
            painter.text(at, Align2::CENTER_BOTTOM, "📌", font, Color32::WHITE);
        }
        if shown.scale {
            self.scale_beside(ui, &place);
        }
        place
    }

    /// Makes the texture of the newest image, unless it is that already.
    fn take(&mut self, ui: &Ui, image: &Image, frames: u64, t_ns: Nanos) {
        let now = (frames, t_ns, image.grid);
        if self.texture.is_some() && self.shown == Some(now) {
            return;
        }
        self.shown = Some(now);
        self.scale = (self.scale * SCALE_FALL).max(FULL_SCALE).max(image.peak());
        let (columns, rows) = (image.grid.columns, image.grid.rows);
        let mut pixels = Vec::with_capacity(columns * rows);
        // Row 0 of an image is at the bottom, of a texture at the top.
        for row in (0..rows).rev() {
            for value in &image.values[row * columns..(row + 1) * columns] {
                let [r, g, b] = heat(value / self.scale);
                pixels.push(Color32::from_rgb(r, g, b));
            }
        }
        let colours = ColorImage::new([columns, rows], pixels);
        match &mut self.texture {
            Some(texture) => texture.set(colours, TextureOptions::LINEAR),
            None => {
                let texture = ui
                    .ctx()
                    .load_texture("pad", colours, TextureOptions::LINEAR);
                self.texture = Some(texture);
            }
        }
    }

    fn image(&self, painter: &egui::Painter, place: &Place, grid: &PixelGrid) {
        let [r, g, b] = heat(0.0);
        painter.rect_filled(place.rect, 4.0, Color32::from_rgb(r, g, b));
        let Some(texture) = &self.texture else { return };
        let [x0, y0] = grid.origin_mm;
        let width = grid.columns as f64 * grid.pixel_mm;
        let height = grid.rows as f64 * grid.pixel_mm;
        let mut mesh = Mesh::with_texture(texture.id());
        for (x, y, u, v) in [
            (x0, y0, 0.0, 1.0),
            (x0 + width, y0, 1.0, 1.0),
            (x0 + width, y0 + height, 1.0, 0.0),
            (x0, y0 + height, 0.0, 0.0),
        ] {
            mesh.vertices.push(Vertex {
                pos: place.of_pad([x, y]),
                uv: Pos2::new(u, v),
                color: Color32::WHITE,
            });
        }
        mesh.indices = vec![0, 1, 2, 0, 2, 3];
        let clipped = painter.with_clip_rect(place.rect.intersect(painter.clip_rect()));
        clipped.add(Shape::mesh(mesh));
    }

    /// The colour scale beside the pad, with its ends in words.
    fn scale_beside(&self, ui: &Ui, place: &Place) {
        let palette = theme::of(ui);
        let height = place.rect.height().min(220.0);
        let bar = Rect::from_min_size(
            place.rect.right_bottom() + Vec2::new(14.0, -height),
            Vec2::new(10.0, height),
        );
        let mut mesh = Mesh::default();
        const STEPS: usize = 24;
        for step in 0..=STEPS {
            let share = step as f32 / STEPS as f32;
            let [r, g, b] = heat(share);
            let y = bar.bottom() - share * height;
            let colour = Color32::from_rgb(r, g, b);
            mesh.colored_vertex(Pos2::new(bar.left(), y), colour);
            mesh.colored_vertex(Pos2::new(bar.right(), y), colour);
            if step > 0 {
                let i = 2 * step as u32;
                mesh.add_triangle(i - 2, i - 1, i);
                mesh.add_triangle(i - 1, i, i + 1);
            }
        }
        let painter = ui.painter();
        painter.add(Shape::mesh(mesh));
        painter.rect_stroke(
            bar,
            1.0,
            Stroke::new(1.0, palette.line),
            egui::StrokeKind::Outside,
        );
        let font = FontId::proportional(11.0);
        let text = |share: f32, words: String| {
            let at = Pos2::new(bar.right() + 5.0, bar.bottom() - share * height);
            painter.text(at, Align2::LEFT_CENTER, words, font.clone(), palette.weak);
        };
        let full = self.scale.max(FULL_SCALE) * 100.0;
        text(0.03, "0 %".to_owned());
        text(0.5, format!("{:.0} %", full / 2.0));
        text(0.97, format!("{full:.0} %"));
    }
}

/// Share of the time that a touch has to wait before it counts, if it has to.
fn waited(playing: &Playing, touch: &Touch) -> Option<f32> {
    let settings = &playing.view.profile.settings;
    let wait_ns = settings.dwell_ns.max(settings.slow_keys_ns);
    if wait_ns == 0 {
        return None;
    }
    let age_ns = playing.view.t_ns.saturating_sub(touch.since_ns);
    Some((age_ns as f32 / wait_ns as f32).min(1.0))
}

fn outline(painter: &egui::Painter, place: &Place, outline: &Outline, ui: &Ui) {
    let line = Stroke::new(1.5, theme::of(ui).line);
    match outline {
        Outline::Rectangle { .. } => {
            painter.rect_stroke(place.rect, 4.0, line, egui::StrokeKind::Outside);
        }
        Outline::Circle { .. } => {
            painter.circle_stroke(place.rect.center(), place.rect.width() / 2.0, line);
        }
    }
}

/// Electrodes as bars at the edge; a lost one is crossed out, not only coloured.
fn electrodes(painter: &egui::Painter, place: &Place, playing: &Playing, ui: &Ui) {
    let palette = theme::of(ui);
    let outline = &playing.pad.outline;
    let [w, h] = outline.size_mm();
    for (index, electrode) in playing.pad.electrodes.iter().enumerate() {
        let lost = playing.view.lost_electrodes.contains(&index);
        let colour = if lost { palette.bad } else { palette.weak };
        let ends =
            [electrode.start_mm, electrode.end_mm()].map(|s| place.of_pad(outline.point_at(s)));
        painter.line_segment(ends, Stroke::new(4.0, colour));
        let middle = outline.point_at((electrode.start_mm + electrode.end_mm()) / 2.0);
        let out = [middle[0] - w / 2.0, middle[1] - h / 2.0];
        let length = out[0].hypot(out[1]).max(1e-9);
        let beyond = 4.5 * 3.0 / f64::from(place.points_per_mm());
        let at = place.of_pad([
            middle[0] + out[0] / length * beyond,
            middle[1] + out[1] / length * beyond,
        ]);
        let words = if lost {
            format!("{}✖", index + 1)
        } else {
            (index + 1).to_string()
        };
        painter.text(
            at,
            Align2::CENTER_CENTER,
            words,
            FontId::proportional(11.0),
            colour,
        );
    }
}

fn region(
    painter: &egui::Painter,
    place: &Place,
    profile: &Profile,
    index: usize,
    state: &RegionState,
) {
    let region = &profile.regions[index];
    let placed = region.placed(place.seen_mm, &profile.settings.area);
    let corners: Vec<Pos2> = placed
        .corners_mm()
        .into_iter()
        .map(|corner| place.of_seen(corner))
        .collect();
    let (low, high) = placed.bounds_mm();
    let bounds = Rect::from_two_pos(place.of_seen(low), place.of_seen(high));
    let accent = theme::palette(true).accent;
    let (line, fill) = if state.held {
        (Stroke::new(3.0, accent), accent.gamma_multiply(0.28))
    } else {
        let white = Color32::from_white_alpha(if region.rest { 70 } else { 130 });
        (Stroke::new(1.2, white), Color32::from_white_alpha(9))
    };
    if corners.len() == 4 || corners.len() > 16 {
        let inset = bounds.shrink(1.5);
        if corners.len() == 4 && is_box(&corners) {
            painter.rect(inset, 5.0, fill, line, egui::StrokeKind::Inside);
        } else {
            painter.add(PathShape::convex_polygon(corners, fill, line));
        }
    } else {
        painter.add(PathShape::closed_line(corners, PathStroke::from(line)));
    }
    label(painter, bounds, &region.name, state);
}

fn is_box(corners: &[Pos2]) -> bool {
    let bounds = Rect::from_points(corners);
    corners.iter().all(|corner| {
        (corner.x == bounds.left() || corner.x == bounds.right())
            && (corner.y == bounds.top() || corner.y == bounds.bottom())
    })
}

/// A region's name, and beneath it what it drives: as large as the room allows.
fn label(painter: &egui::Painter, bounds: Rect, name: &str, state: &RegionState) {
    let letters = name.chars().count().max(1) as f32;
    let size = (bounds.width() / letters * 1.6)
        .min(bounds.height() * 0.4)
        .min(17.0);
    if size < SMALLEST_TEXT {
        return;
    }
    let two_lines = !state.drives.is_empty() && bounds.height() > 2.6 * size;
    let colour = if state.held {
        Color32::WHITE
    } else {
        Color32::from_white_alpha(215)
    };
    let at = bounds.center() - Vec2::new(0.0, if two_lines { size * 0.6 } else { 0.0 });
    let words = if state.held {
        format!("▼ {name}")
    } else {
        name.to_owned()
    };
    painter.text(
        at,
        Align2::CENTER_CENTER,
        words,
        FontId::proportional(size),
        colour,
    );
    if two_lines {
        let below = bounds.center() + Vec2::new(0.0, size * 0.65);
        let font = FontId::monospace((size * 0.8).max(SMALLEST_TEXT));
        painter.text(
            below,
            Align2::CENTER_CENTER,
            &state.drives,
            font,
            Color32::from_white_alpha(if state.held { 255 } else { 165 }),
        );
    }
}

/// The way that a touch has come, fading.
fn trail(painter: &egui::Painter, place: &Place, stroke: &TouchStroke, now_ns: Nanos) {
    let colour = theme::touch(stroke.id);
    let recent = |t_ns: Nanos| now_ns.saturating_sub(t_ns) < TRAIL_NS;
    let moments = stroke.moments.iter().filter(|m| recent(m.t_ns));
    let mut last: Option<Pos2> = None;
    for moment in moments {
        let at = place.of_pad(moment.place_mm);
        if let Some(from) = last {
            let age = now_ns.saturating_sub(moment.t_ns) as f32 / TRAIL_NS as f32;
            let width = 1.0 + 5.0 * moment.force * (1.0 - age);
            let line = Stroke::new(width, colour.gamma_multiply(0.8 * (1.0 - age)));
            painter.line_segment([from, at], line);
        }
        last = Some(at);
    }
}

/// A touch: its footprint, its force as an arc around it, its number.
fn draw_touch(painter: &egui::Painter, place: &Place, touch: &Touch, waited: Option<f32>) {
    let colour = theme::touch(touch.id.0);
    let at = place.of_pad(touch.contact.centre_mm);
    let radius_mm = (touch.contact.area_mm2 / std::f64::consts::PI)
        .max(0.0)
        .sqrt() as f32;
    let radius = (radius_mm * place.points_per_mm()).clamp(9.0, 60.0);
    painter.circle(
        at,
        radius,
        colour.gamma_multiply(0.25),
        Stroke::new(1.5, colour),
    );
    let force = touch.contact.force.clamp(0.0, 1.0) as f32;
    arc(painter, at, radius + 5.0, force, Stroke::new(3.5, colour));
    if let Some(share) = waited {
        let line = Stroke::new(3.0, Color32::WHITE);
        arc(painter, at, radius + 10.0, share, line);
    }
    painter.circle_filled(at, 8.5, Color32::from_black_alpha(190));
    painter.text(
        at,
        Align2::CENTER_CENTER,
        (touch.id.0 % 100).to_string(),
        FontId::proportional(12.0),
        Color32::WHITE,
    );
}

/// A part of a circle, clockwise from the top.
fn arc(painter: &egui::Painter, centre: Pos2, radius: f32, share: f32, line: Stroke) {
    const STEPS: f32 = 40.0;
    let steps = (share * STEPS).ceil() as usize;
    if steps == 0 {
        return;
    }
    let points = (0..=steps)
        .map(|step| {
            let angle = std::f32::consts::TAU * share * step as f32 / steps as f32;
            centre + radius * Vec2::new(angle.sin(), -angle.cos())
        })
        .collect();
    painter.add(PathShape::line(points, PathStroke::from(line)));
}
