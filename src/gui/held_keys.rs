//! A key that is held clicks once: a slow hand, or a switch that acts as a key, holds Enter or Space longer than the desktop's delay of
//! repetition, and each repetition would click again.

use egui::{Event, Key, Ui};

/// Removes repetitions of Enter, and of Space where no text is typed, before a widget acts on them.
pub(super) fn drop_repeated_clicks(ui: &Ui) {
    let types_text = ui.ctx().text_edit_focused();
    ui.input_mut(|input| {
        input.events.retain(|event| match event {
            Event::Key {
                key: Key::Enter,
                pressed: true,
                repeat: true,
                ..
            } => false,
            Event::Key {
                key: Key::Space,
                pressed: true,
                repeat: true,
                ..
            } => types_text,
            _ => true,
        });
    });
}
