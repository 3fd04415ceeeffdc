//! The list of views at the left of the window.

use egui::{CornerRadius, Rect, Sense, Stroke, Ui, Vec2};

use super::tab::Tab;
use super::theme;

/// Smallest and largest height of a view's button, points.
const HEIGHTS: (f32, f32) = (theme::MIN_TARGET, 62.0);
/// Buttons of this height have an icon above the name, points.
const WITH_ICON: f32 = 44.0;

/// Draws the list of views; `current` is the one that is shown.
pub(super) fn draw(ui: &mut Ui, room: Rect, current: &mut Tab) {
    let palette = theme::palette_of(ui);
    ui.painter().rect_filled(room, 0.0, palette.card);
    ui.painter().vline(
        room.right(),
        room.y_range(),
        Stroke::new(1.0, palette.line.gamma_multiply(0.6)),
    );
    let mut rail = ui.new_child(
        egui::UiBuilder::new()
            .id_salt("rail")
            .max_rect(room.shrink(6.0)),
    );
    rail.spacing_mut().item_spacing.y = 4.0;
    let size = (((room.height() - 60.0) / Tab::ALL.len() as f32) - 4.0).clamp(HEIGHTS.0, HEIGHTS.1);
    let (name, _) = rail.allocate_exact_size(Vec2::new(room.width() - 12.0, 30.0), Sense::hover());
    theme::centred_text(
        rail.painter(),
        name.center(),
        "gelpad",
        if room.width() > 80.0 { 19.0 } else { 16.0 },
        palette.accent,
    );
    // The smallest windows leave no room for all.
    let scroll = egui::ScrollArea::vertical().id_salt("views");
    scroll.show(&mut rail, |ui| {
        for tab in Tab::ALL {
            if button(ui, tab, *current == tab, size) {
                *current = tab;
            }
        }
    });
}

/// A view's button; returns whether it was clicked.
fn button(ui: &mut Ui, tab: Tab, chosen: bool, height: f32) -> bool {
    let palette = theme::palette_of(ui);
    let (rect, response) =
        ui.allocate_exact_size(Vec2::new(ui.available_width(), height), Sense::click());
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Tab, true, chosen, tab.name()));
    let painter = ui.painter();
    let round = CornerRadius::same(theme::ROUND);
    if chosen {
        painter.rect_filled(rect, round, palette.accent.gamma_multiply(0.18));
        let edge = Rect::from_min_size(
            rect.left_top() + Vec2::new(0.0, height * 0.15),
            Vec2::new(3.0, height * 0.7),
        );
        painter.rect_filled(edge, 2.0, palette.accent);
    } else if response.hovered() {
        painter.rect_filled(rect, round, palette.line.gamma_multiply(0.4));
    }
    let colour = if chosen { palette.accent } else { palette.text };
    let mut name_at = rect.center();
    if height >= WITH_ICON {
        let icon_at = rect.center() - Vec2::new(0.0, height * 0.14);
        theme::centred_text(painter, icon_at, tab.icon(), 19.0, colour);
        name_at.y += height * 0.28;
    }
    theme::centred_text(painter, name_at, tab.name(), 12.5, colour);
    let key = format!("{:?}", tab.key());
    if response.gained_focus() {
        response.scroll_to_me(None);
    }
    response.on_hover_text(key).clicked()
}
