//! A ring around the control that has the keyboard focus: two colours, so that one of them contrasts with any background.
//!
//! It is shown while the keyboard moves the focus, and hidden when the mouse is used.

use egui::{Event, Key, LayerId, Order, Stroke, StrokeKind, Ui};

use super::theme;

/// Distance of the ring from the control, points.
const GAP: f32 = 2.0;
/// What is seen around a control that was scrolled to, points.
const SEEN: f32 = 8.0;

/// Scrolls to the control that the keyboard has moved the focus to. Called at the end of what scrolls.
pub(super) fn follow_focus(ui: &Ui) {
    let id = ui.make_persistent_id("followed focus");
    let followed: Option<egui::Id> = ui.data(|data| data.get_temp(id));
    let focused = ui.memory(|memory| memory.focused());
    if focused == followed {
        return;
    }
    ui.data_mut(|data| match focused {
        Some(focused) => drop(data.insert_temp(id, focused)),
        None => data.remove::<egui::Id>(id),
    });
    let response = focused.and_then(|focused| ui.ctx().read_response(focused));
    if let Some(response) = response
        && response.layer_id == ui.layer_id()
        && ui.min_rect().contains(response.rect.center())
        && !ui.input(|input| input.pointer.any_down())
    {
        ui.scroll_to_rect(response.rect.expand(SEEN), None);
    }
}

/// Whether the keyboard moved the focus last.
#[derive(Default)]
pub(super) struct FocusRing {
    by_keyboard: bool,
}

impl FocusRing {
    /// Draws the ring; called after all controls.
    pub(super) fn draw(&mut self, ui: &Ui) {
        let ctx = ui.ctx();
        ctx.input(|input| {
            for event in &input.events {
                match event {
                    Event::Key {
                        key: Key::Tab,
                        pressed: true,
                        ..
                    } => self.by_keyboard = true,
                    Event::PointerButton { pressed: true, .. } => self.by_keyboard = false,
                    _ => {}
                }
            }
        });
        let focused = ctx.memory(|memory| memory.focused());
        let Some(response) = focused.and_then(|id| ctx.read_response(id)) else {
            return;
        };
        if !self.by_keyboard || !response.interact_rect.is_positive() {
            return;
        }
        let palette = theme::palette_of(ui);
        let layer = LayerId::new(Order::Foreground, egui::Id::unique("focus ring"));
        let painter = ctx.layer_painter(layer);
        let rect = response.interact_rect.expand(GAP);
        for (width, colour) in [(4.0, palette.ground), (2.0, palette.text)] {
            let line = Stroke::new(width, colour);
            painter.rect_stroke(rect, f32::from(theme::ROUND), line, StrokeKind::Outside);
        }
    }
}
