//! A drop-down list that also works with the keyboard alone: Enter chooses and closes, Tab past its end or Esc closes, and the
//! focus returns to the list's button.

use egui::{ComboBox, Popup, Response, Ui};

/// An entry of a list: its value and its label.
pub(super) type Entry<T> = (T, String);

/// Draws a list with a label for screen readers; returns the chosen value, if it is another one.
pub(super) fn list<T: PartialEq>(
    ui: &mut Ui,
    combo: ComboBox,
    label: Option<&Response>,
    current: &T,
    entries: Vec<Entry<T>>,
) -> Option<T> {
    let mut chosen = None;
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
