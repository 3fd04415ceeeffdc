//! The pad-only window: small, always on top, never takes the focus, so that the mouse presses it while the game has the
//! keyboard. As an overlay it shows regions and touches only, and clicks go through it to the game below.
//!
//! On X11 it is an override-redirect window: no window manager gives such a window the focus, nor does a click on it. Elsewhere
//! the system is requested to keep it inactive and on top.

use egui::{Color32, Pos2, Rect, Sense, Stroke, Vec2, ViewportBuilder, ViewportId};

use super::comfort::preferences::Preferences;
use super::picture::{Picture, PictureLayers};
use super::play;
use super::playing::Playing;
use super::theme;

/// Height of the pad, points.
const SIDE: f32 = 300.0;
/// Height of the title bar, points.
const BAR: f32 = 24.0;
/// Smallest and largest size, points.
const SIZES: (Vec2, Vec2) = (Vec2::new(120.0, 110.0), Vec2::new(1600.0, 1200.0));
/// Side of the corner that is dragged to resize it, points.
const GRIP: f32 = 16.0;
/// The shares of opacity that its button goes through.
const OPACITIES: [f32; 3] = [1.0, 0.7, 0.4];

/// The window.
pub struct PadWindow {
    /// Whether it is open.
    pub open: bool,
    /// Whether it is an overlay: without image and bar, and clicks go through it.
    pub is_overlay: bool,
    /// Position of its top-left corner on the screen, points; none before it was opened.
    pub place: Option<Pos2>,
    /// Its size, points; none: that of the pad.
    pub size: Option<Vec2>,
    /// Opacity, 0 to 1.
    pub opacity: f32,
    /// Whether it was open in the last session, until this one opens or closes it.
    was_open: bool,
    /// Whether the desktop can show what is behind it.
    pub can_be_transparent: bool,
    picture: Picture,
}

impl Default for PadWindow {
    fn default() -> Self {
        Self {
            open: false,
            is_overlay: false,
            place: None,
            size: None,
            opacity: 1.0,
            was_open: false,
            can_be_transparent: false,
            picture: Picture::default(),
        }
    }
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
    /// Closed, with the position, size and opacity of the last session.
    pub fn from_preferences(preferences: &Preferences) -> Self {
        Self {
            place: preferences.pad_window.map(Pos2::from),
            size: preferences.pad_window_size.map(clamped_size),
            opacity: preferences.pad_window_opacity,
            was_open: preferences.pad_window_open,
            ..Self::default()
        }
    }

    /// Takes position, size and opacity into the preferences.
    pub fn store(&self, preferences: &mut Preferences) {
        preferences.pad_window = self.place.map(|place| [place.x, place.y]);
        preferences.pad_window_size = self.size.map(|size| [size.x, size.y]);
        preferences.pad_window_opacity = self.opacity;
        preferences.pad_window_open = self.shows_pad() || self.was_open;
    }

    /// The id of its viewport.
    pub fn id() -> ViewportId {
        ViewportId::from_hash_of("pad window")
    }

    /// Whether it is open with a pad that can be pressed.
    #[must_use]
    pub fn shows_pad(&self) -> bool {
        self.open && !self.is_overlay
    }

    /// Opens it, or makes a pad of the overlay; closes an open pad.
    pub fn toggle_pad(&mut self) {
        self.was_open = false;
        (self.open, self.is_overlay) = (!self.shows_pad(), false);
    }

    /// Opens it if it was open in the last session.
    pub fn reopen(&mut self) {
        if std::mem::take(&mut self.was_open) && !self.open {
            self.toggle_pad();
        }
    }

    /// Opens or closes the overlay.
    pub fn toggle_overlay(&mut self) {
        self.was_open = false;
        (self.open, self.is_overlay) = match self.open && self.is_overlay {
            true => (false, false),
            false => (true, true),
        };
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
        let own_size = Vec2::new(SIDE * (w / h) as f32, SIDE + BAR);
        let size = self.size.unwrap_or(own_size);
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
            .with_always_on_top()
            .with_active(false)
            .with_taskbar(false)
            .with_transparent(self.can_be_transparent)
            .with_mouse_passthrough(self.is_overlay)
            .with_override_redirect(true);
        let mut close = false;
        ctx.show_viewport_immediate(Self::id(), builder, |ui, _| {
            if self.is_overlay {
                self.draw_overlay(ui, playing);
            } else {
                close = self.draw_pad(ui, playing);
            }
        });
        if close || ctx.input_for(Self::id(), |input| input.viewport().close_requested()) {
            self.open = false;
        }
    }

    /// Regions and touches alone.
    fn draw_overlay(&mut self, ui: &mut egui::Ui, playing: &Playing) {
        let room = ui.max_rect();
        if !self.can_be_transparent {
            let palette = theme::palette_of(ui);
            ui.painter().rect_filled(room, 0.0, palette.ground);
        }
        let layers = PictureLayers {
            image: false,
            regions: true,
            electrodes: false,
            scale: false,
        };
        let profile = &playing.view.profile;
        self.picture.draw(ui, room, playing, profile, layers);
    }

    /// The pad with its bar; returns whether the close button was clicked.
    fn draw_pad(&mut self, ui: &mut egui::Ui, playing: &mut Playing) -> bool {
        if self.can_be_transparent {
            ui.set_opacity(self.opacity);
        }
        let palette = theme::palette_of(ui);
        let room = ui.max_rect();
        ui.painter().rect_filled(room, 0.0, palette.ground);
        let bar = Rect::from_min_size(room.min, Vec2::new(room.width(), BAR));
        let close = self.draw_bar(ui, bar);
        let body = Rect::from_min_max(bar.left_bottom(), room.max).shrink(2.0);
        play::pad(ui, body, &mut self.picture, playing, false);
        self.resize(ui, room);
        let line = Stroke::new(1.0, Color32::from_gray(90));
        ui.painter()
            .rect_stroke(room, 0.0, line, egui::StrokeKind::Inside);
        close
    }

    /// The bar: it moves the window; its buttons change the opacity and close it. Returns whether it is to be closed.
    fn draw_bar(&mut self, ui: &mut egui::Ui, bar: Rect) -> bool {
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
            theme::palette_of(ui).weak,
        );
        let button = |nth: f32| {
            Rect::from_min_size(
                bar.right_top() - Vec2::new(nth * BAR, 0.0),
                Vec2::splat(BAR),
            )
        };
        if self.can_be_transparent {
            let percent = (self.opacity * 100.0).round();
            let label = format!("Opacity: {percent:.0} %");
            let see = ui.put(button(2.0), egui::Button::new("◐").frame(false));
            see.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, label.clone()));
            if see.on_hover_text(&label).clicked() {
                self.opacity = next_opacity(self.opacity);
            }
        }
        let close = ui.put(button(1.0), egui::Button::new("✖").frame(false));
        close.on_hover_text("Close the pad window").clicked()
    }

    /// The corner that is dragged to resize the window.
    fn resize(&mut self, ui: &mut egui::Ui, room: Rect) {
        let corner = Rect::from_min_max(room.max - Vec2::splat(GRIP), room.max);
        let grip = ui.interact(corner, ui.scope_id().with("resize"), Sense::drag());
        let grip = grip.on_hover_and_drag_cursor(egui::CursorIcon::ResizeNwSe);
        if let Some(pointer) = grip.interact_pointer_pos().filter(|_| grip.dragged()) {
            self.size = Some(clamped_size((pointer - room.min).into()));
            ui.ctx().request_repaint_of(ViewportId::ROOT);
        }
        let line = Stroke::new(1.5, theme::palette_of(ui).weak);
        for inset in [4.0, 8.0, 12.0] {
            let ends = [
                Pos2::new(room.right() - inset, room.bottom() - 2.0),
                Pos2::new(room.right() - 2.0, room.bottom() - inset),
            ];
            ui.painter().line_segment(ends, line);
        }
    }
}

/// The opacity after this one.
fn next_opacity(opacity: f32) -> f32 {
    let smaller = OPACITIES.into_iter().find(|next| *next < opacity - 0.01);
    smaller.unwrap_or(OPACITIES[0])
}

fn clamped_size(size: [f32; 2]) -> Vec2 {
    Vec2::from(size).clamp(SIZES.0, SIZES.1)
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

    #[test]
    fn the_opacity_goes_through_its_steps_and_starts_again() {
        assert_eq!(next_opacity(1.0), 0.7);
        assert_eq!(next_opacity(0.7), 0.4);
        assert_eq!(next_opacity(0.4), 1.0);
        assert_eq!(next_opacity(0.55), 0.4, "typed into the file");
    }

    #[test]
    fn the_overlay_is_opened_and_closed_and_becomes_a_pad_again() {
        let mut window = PadWindow::default();
        window.toggle_overlay();
        assert!(window.open && window.is_overlay);
        window.toggle_pad();
        assert!(window.shows_pad());
        window.toggle_overlay();
        window.toggle_overlay();
        assert!(!window.open);
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
