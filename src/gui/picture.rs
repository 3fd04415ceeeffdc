//! The picture of the pad: conductivity image with its colour scale; `overlay.rs` draws regions, electrodes and touches on it.

use egui::epaint::{Mesh, Vertex};
use egui::{
    Align2, Color32, ColorImage, FontId, Pos2, Rect, Shape, Stroke, TextureHandle, TextureOptions,
    Ui, Vec2,
};

use super::overlay;
use super::place::PadTransform;
use super::playing::Playing;
use super::regions;
use super::theme;
use crate::profile::Profile;
use crate::types::{Image, Nanos, PixelGrid, heat_colour};

/// End of the colour scale as a relative rise of conductivity, unless the image has a higher peak.
const FULL_SCALE: f32 = 0.3;
/// Factor per frame by which the scale falls back after a higher peak, so that colours do not flicker.
const SCALE_FALL: f32 = 0.985;
/// Width of the scale beside the picture, points.
const SCALE_WIDTH: f32 = 54.0;

/// What is drawn in addition to the image.
#[derive(Clone, Copy, Debug)]
pub struct PictureLayers {
    /// The conductivity image.
    pub image: bool,
    /// Regions with their names.
    pub regions: bool,
    /// Electrodes with their numbers.
    pub electrodes: bool,
    /// The colour scale.
    pub scale: bool,
}

/// The newest image as a texture, and its scale.
#[derive(Default)]
pub struct Picture {
    texture: Option<TextureHandle>,
    shown: Option<(u64, Nanos, PixelGrid)>,
    scale: f32,
}

impl Picture {
    /// Draws the pad with the regions of a profile into `room`; returns its coordinates.
    pub fn draw(
        &mut self,
        ui: &Ui,
        room: Rect,
        playing: &Playing,
        profile: &Profile,
        shown: PictureLayers,
    ) -> PadTransform {
        let view = &playing.view;
        let edge = if shown.electrodes { 22.0 } else { 4.0 };
        let mut inner = room.shrink(edge);
        if shown.scale {
            inner.max.x -= SCALE_WIDTH;
        }
        let pad_mm = playing.pad.outline.size_mm();
        let place = PadTransform::fit(inner, pad_mm, &profile.settings);
        if place.rect.width() < 8.0 {
            return place;
        }
        let painter = ui.painter_at(room);
        if shown.image {
            self.update_texture(ui, &view.image, view.frames, view.t_ns);
            self.draw_image(&painter, &place, &view.image.grid);
        }
        overlay::outline(&painter, &place, &playing.pad.outline, ui);
        if shown.electrodes {
            overlay::electrodes(&painter, &place, playing, ui);
        }
        if shown.regions {
            let states = regions::region_states(profile, &view.held);
            // The first region has priority and is drawn last.
            for index in (0..states.len()).rev() {
                overlay::region(&painter, &place, profile, index, &states[index]);
            }
        }
        for stroke in &playing.history.strokes {
            overlay::trail(&painter, &place, stroke, playing.history.now_ns);
        }
        for touch in &view.touches {
            overlay::touch(&painter, &place, touch, overlay::wait_share(view, touch));
        }
        for pinned in playing.fingers.pinned_mm() {
            let at = place.screen_from_pad(pinned) + Vec2::new(0.0, -12.0);
            let font = FontId::proportional(15.0);
            painter.text(at, Align2::CENTER_BOTTOM, "📌", font, Color32::WHITE);
        }
        if shown.scale {
            self.draw_scale(ui, &place);
        }
        place
    }

    /// Updates the texture if the image is new.
    fn update_texture(&mut self, ui: &Ui, image: &Image, frames: u64, t_ns: Nanos) {
        let now = (frames, t_ns, image.grid);
        if self.texture.is_some() && self.shown == Some(now) {
            return;
        }
        self.shown = Some(now);
        self.scale = (self.scale * SCALE_FALL).max(FULL_SCALE).max(image.peak());
        let (columns, rows) = (image.grid.columns, image.grid.rows);
        let mut pixels = Vec::with_capacity(columns * rows);
        // Row 0 is at the bottom of an image, at the top of a texture.
        for row in (0..rows).rev() {
            for value in &image.values[row * columns..(row + 1) * columns] {
                let [r, g, b] = heat_colour(value / self.scale);
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

    fn draw_image(&self, painter: &egui::Painter, place: &PadTransform, grid: &PixelGrid) {
        let [r, g, b] = heat_colour(0.0);
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
                pos: place.screen_from_pad([x, y]),
                uv: Pos2::new(u, v),
                color: Color32::WHITE,
            });
        }
        mesh.indices = vec![0, 1, 2, 0, 2, 3];
        let clipped = painter.with_clip_rect(place.rect.intersect(painter.clip_rect()));
        clipped.add(Shape::mesh(mesh));
    }

    /// Draws the colour scale beside the pad, labelled in percent.
    fn draw_scale(&self, ui: &Ui, place: &PadTransform) {
        let palette = theme::palette_of(ui);
        let height = place.rect.height().min(220.0);
        let bar = Rect::from_min_size(
            place.rect.right_bottom() + Vec2::new(14.0, -height),
            Vec2::new(10.0, height),
        );
        let mut mesh = Mesh::default();
        const STEPS: usize = 24;
        for step in 0..=STEPS {
            let share = step as f32 / STEPS as f32;
            let [r, g, b] = heat_colour(share);
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
        let text = |share: f32, label: String| {
            let at = Pos2::new(bar.right() + 5.0, bar.bottom() - share * height);
            painter.text(at, Align2::LEFT_CENTER, label, font.clone(), palette.weak);
        };
        let full = self.scale.max(FULL_SCALE) * 100.0;
        text(0.03, "0 %".to_owned());
        text(0.5, format!("{:.0} %", full / 2.0));
        text(0.97, format!("{full:.0} %"));
    }
}
