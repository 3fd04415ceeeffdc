//! The pad-only window: small, always on top, never takes the focus, so that the mouse presses it while the game has the
//! keyboard.
//!
//! On X11 it is an override-redirect window: no window manager gives such a window the focus, nor does a click on it. Elsewhere
//! the system is requested to keep it inactive and on top.

use egui::{Color32, Pos2, Rect, Sense, Stroke, Vec2, ViewportBuilder, ViewportId};

use super::picture::Picture;
use super::play;
use super::playing::Playing;
use super::theme;

/// Height of the pad, points.
const SIDE: f32 = 300.0;
/// Height of the title bar, points.
const BAR: f32 = 24.0;

/// The window.
#[derive(Default)]
pub struct PadWindow {
    /// Whether it is open.
    pub open: bool,
    picture: Picture,
}

impl PadWindow {
    /// The id of its viewport.
    pub fn id() -> ViewportId {
        ViewportId::from_hash_of("pad window")
    }

    /// Draws it, if it is open.
    pub fn show(&mut self, ctx: &egui::Context, playing: &mut Playing) {
        if !self.open {
            return;
        }
        let [w, h] = playing
            .view
            .profile
            .settings
            .size_as_player_sees_mm(playing.pad.outline.size_mm());
        let builder = ViewportBuilder::default()
            .with_title("gelpad pad")
            .with_inner_size([SIDE * (w / h) as f32, SIDE + BAR])
            .with_position([40.0, 40.0])
            .with_decorations(false)
            .with_resizable(false)
            .with_always_on_top()
            .with_active(false)
            .with_taskbar(false)
            .with_override_redirect(true);
        let mut close = false;
        ctx.show_viewport_immediate(Self::id(), builder, |ui, _| {
            close = self.ui(ui, playing);
        });
        if close || ctx.input_for(Self::id(), |input| input.viewport().close_requested()) {
            self.open = false;
        }
    }

    /// Draws the content; returns whether the close button was clicked.
    fn ui(&mut self, ui: &mut egui::Ui, playing: &mut Playing) -> bool {
        let palette = theme::palette_of(ui);
        let room = ui.max_rect();
        ui.painter().rect_filled(room, 0.0, palette.ground);
        let bar = Rect::from_min_size(room.min, Vec2::new(room.width(), BAR));
        let grip = ui.interact(bar, ui.scope_id().with("move"), Sense::drag());
        if grip.dragged() {
            let outer = ui.ctx().input(|input| input.viewport().outer_rect);
            if let Some(outer) = outer {
                let at = outer.min + grip.drag_delta();
                ui.ctx()
                    .send_viewport_cmd(egui::ViewportCommand::OuterPosition(at));
            }
        }
        ui.painter().text(
            Pos2::new(bar.left() + 8.0, bar.center().y),
            egui::Align2::LEFT_CENTER,
            "gelpad: drag to move",
            egui::FontId::proportional(12.0),
            palette.weak,
        );
        let cross = Rect::from_min_size(bar.right_top() - Vec2::new(BAR, 0.0), Vec2::splat(BAR));
        let close = ui
            .put(cross, egui::Button::new("✖").frame(false))
            .on_hover_text("Close the pad window");
        let body = Rect::from_min_max(bar.left_bottom(), room.max).shrink(2.0);
        play::pad(ui, body, &mut self.picture, playing, false);
        let line = Stroke::new(1.0, Color32::from_gray(90));
        ui.painter()
            .rect_stroke(room, 0.0, line, egui::StrokeKind::Inside);
        close.clicked()
    }
}
