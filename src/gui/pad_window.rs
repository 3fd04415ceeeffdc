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
    /// Position of its top-left corner on the screen, points; none before it was opened.
    pub place: Option<Pos2>,
    picture: Picture,
}

/// The bottom-right corner of a screen: the middle belongs to the game.
fn corner(screen: Option<Vec2>, size: Vec2) -> Pos2 {
    const MARGIN: Vec2 = Vec2::new(24.0, 72.0);
    match screen {
        Some(screen) => (screen - size - MARGIN).max(Vec2::ZERO).to_pos2(),
        None => Pos2::new(40.0, 40.0),
    }
}

/// Whether enough of a window is on the screen to drag it.
fn fits(place: Pos2, screen: Vec2) -> bool {
    const SEEN: f32 = 60.0;
    let x = -SEEN..=screen.x - SEEN;
    let y = -BAR / 2.0..=screen.y - BAR;
    x.contains(&place.x) && y.contains(&place.y)
}

/// How far the pointer is from where it pressed, if it has just moved. The pointer is measured from the window, which follows
/// it: the distance is what the window still has to move, and counts once for each motion of the pointer.
fn pointer_moved_by(ui: &egui::Ui) -> Option<Vec2> {
    ui.input(|input| {
        let moved = |event: &egui::Event| matches!(event, egui::Event::PointerMoved(_));
        let (at, from) = (input.pointer.latest_pos()?, input.pointer.press_origin()?);
        input.events.iter().any(moved).then_some(at - from)
    })
}

impl PadWindow {
    /// Closed, with the position where it was last.
    pub fn at(place: Option<[f32; 2]>) -> Self {
        Self {
            place: place.map(Pos2::from),
            ..Self::default()
        }
    }

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
        let size = Vec2::new(SIDE * (w / h) as f32, SIDE + BAR);
        let screen = ctx.input_for(ViewportId::ROOT, |input| input.viewport().monitor_size);
        // A place of a screen that is gone is not used.
        let is_on_screen = |place: &Pos2| screen.is_none_or(|screen| fits(*place, screen));
        let place = self.place.filter(is_on_screen);
        let place = place.unwrap_or_else(|| corner(screen, size));
        self.place = Some(place);
        let builder = ViewportBuilder::default()
            .with_title("gelpad pad")
            .with_inner_size(size)
            .with_position(place)
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
        if grip.dragged()
            && let (Some(place), Some(by)) = (self.place, pointer_moved_by(ui))
        {
            // The next pass requests this position.
            self.place = Some(place + by);
            ui.ctx().request_repaint_of(ViewportId::ROOT);
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

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Event, PointerButton, RawInput};

    #[test]
    fn it_opens_in_the_corner_and_on_small_screens_within_them() {
        let size = Vec2::new(300.0, 324.0);
        let at = corner(Some(Vec2::new(1920.0, 1080.0)), size);
        assert!(at.x > 1500.0 && at.y > 600.0, "{at:?}");
        assert_eq!(corner(Some(Vec2::new(200.0, 200.0)), size), Pos2::ZERO);
    }

    /// What a drag asks of the window for each event: it moves as far as the pointer does on the screen.
    #[test]
    fn the_window_follows_the_pointer_all_the_way() {
        let ctx = egui::Context::default();
        let by = |events: Vec<Event>| {
            let mut moved = None;
            let input = RawInput {
                events,
                ..RawInput::default()
            };
            let mut output = ctx.run_ui(input, |ui| moved = pointer_moved_by(ui));
            output.textures_delta.clear();
            moved
        };
        let start = Pos2::new(50.0, 10.0);
        by(vec![
            Event::PointerMoved(start),
            Event::PointerButton {
                pos: start,
                button: PointerButton::Primary,
                pressed: true,
                modifiers: egui::Modifiers::NONE,
            },
        ]);
        // The pointer moves by 10 points twice. The window has followed the first time: it sees the same place again.
        let seen = start + Vec2::new(10.0, 0.0);
        for _ in 0..2 {
            let moved = by(vec![Event::PointerMoved(seen)]);
            assert_eq!(moved, Some(Vec2::new(10.0, 0.0)));
        }
        assert_eq!(by(Vec::new()), None, "nothing moves a window at rest");
    }
}
