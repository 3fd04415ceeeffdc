//! A drop-down list that also works with the keyboard alone: Enter chooses and closes, Tab past its end or Esc closes, and the
//! focus returns to the list's button.

use egui::{ComboBox, Popup, PopupCloseBehavior, Response, Ui};

/// An entry of a list: its value and its label.
pub(super) type Entry<T> = (T, String);

/// Largest share of the window's height for a list.
const SHARE: f32 = 0.7;

/// Draws a list with a label for screen readers; returns the chosen value, if it is another one.
pub(super) fn list<T: PartialEq>(
    ui: &mut Ui,
    combo: ComboBox,
    label: Option<&Response>,
    current: &T,
    entries: Vec<Entry<T>>,
) -> Option<T> {
    let mut chosen = None;
    // A press on the list's own scroll bar leaves it open.
    let combo = combo
        .height(list_height(ui, entries.len()))
        .close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    let shown = combo.show_ui(ui, |ui| {
        let mut has_focus = false;
        for (value, text) in entries {
            let entry = ui.selectable_label(value == *current, text);
            has_focus |= entry.has_focus();
            if entry.clicked() {
                chosen = Some(value);
            }
        }
        has_focus
    });
    let button = match label {
        Some(label) => shown.response.labelled_by(label.id),
        None => shown.response,
    };
    let entry_has_focus = shown.inner?;
    if chosen.is_some() {
        Popup::close_all(ui.ctx());
        button.request_focus();
    } else if ui.memory(|memory| memory.focused().is_some_and(|id| id != button.id))
        && !entry_has_focus
    {
        // The focus has moved on to another control.
        Popup::close_all(ui.ctx());
    }
    chosen.filter(|chosen| chosen != current)
}

/// The height of a list in whole rows: none is cut.
fn list_height(ui: &Ui, entries: usize) -> f32 {
    let row = ui.spacing().interact_size.y;
    let gap = ui.spacing().item_spacing.y;
    let room = ui.ctx().content_rect().height() * SHARE;
    rows_within(room, row + gap, entries) as f32 * (row + gap) - gap
}

/// Rows of a list that fit into a height; a list shows a few even where they do not.
fn rows_within(room: f32, row: f32, entries: usize) -> usize {
    let fitting = (room / row).floor().max(3.0) as usize;
    fitting.min(entries.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_shows_whole_rows() {
        assert_eq!(rows_within(200.0, 35.0, 14), 5);
        assert_eq!(rows_within(600.0, 35.0, 14), 14);
        assert_eq!(rows_within(50.0, 35.0, 14), 3);
        assert_eq!(rows_within(50.0, 35.0, 0), 1);
    }
}
