//! A plugin of egui that completes the tree of controls before screen readers get it: it names the window, marks the tab of the
//! current view as selected, and replaces symbols such as `✖` by words or leaves them out.
//!
//! Invariant: the words of a control's name stay as they are; only symbols change.

use egui::accesskit::{Node, Role, Toggled};
use egui::{Context, FullOutput, Plugin};

/// Words for symbols at the start of a text. On a control they are left out, since its name says the same.
const MARKS: [(char, &str); 2] = [('✖', "error:"), ('⚠', "warning:")];
/// The word for an arrow.
const TO: (char, &str) = ('→', "to");
/// Symbols that are left out, since the text beside them says the same.
const SILENT: [char; 13] = [
    '●', 'ℹ', '✔', '⏸', '⏺', '⏹', '▶', '◀', '⟲', '⟳', '🗖', '▾', '·',
];

/// The plugin; see the module.
pub(super) struct ScreenReaderTree;

impl Plugin for ScreenReaderTree {
    fn debug_name(&self) -> &'static str {
        "screen reader tree"
    }

    fn output_hook(&mut self, ctx: &Context, output: &mut FullOutput) {
        let Some(update) = &mut output.platform_output.accesskit_update else {
            return;
        };
        let root = update.tree.as_ref().map(|tree| tree.root);
        for (id, node) in &mut update.nodes {
            if Some(*id) == root && node.label().is_none() {
                let title = ctx.input(|input| input.viewport().title.clone());
                let title = title.filter(|title| !title.is_empty());
                node.set_label(title.unwrap_or_else(|| "gelpad".to_owned()));
            }
            complete(node);
        }
    }
}

fn complete(node: &mut Node) {
    let name = node.label().map(|label| spoken(label, false));
    if let Some(name) = name.filter(|name| !name.is_empty()) {
        node.set_label(name);
    }
    match node.role() {
        // The text of a label is its value; one without words says nothing.
        Role::Label => match node.value().map(|text| spoken(text, true)) {
            Some(value) if value.is_empty() => node.set_hidden(),
            Some(value) => node.set_value(value),
            None => {}
        },
        Role::Tab => {
            node.set_selected(node.toggled() == Some(Toggled::True));
            node.clear_toggled();
        }
        Role::ScrollBar if node.label().is_none() => node.set_label("Scroll"),
        _ => {}
    }
}

/// Replaces the symbols of a text by words; marks are left out unless `has_marks`.
fn spoken(text: &str, has_marks: bool) -> String {
    let is_mark = |symbol| MARKS.iter().any(|(mark, _)| *mark == symbol);
    let is_symbol = |symbol| is_mark(symbol) || symbol == TO.0 || SILENT.contains(&symbol);
    if !text.contains(is_symbol) {
        return text.to_owned();
    }
    let mut spoken = String::with_capacity(text.len());
    for symbol in text.chars() {
        let mark = MARKS.iter().find(|(mark, _)| *mark == symbol);
        match mark {
            Some((_, word)) if has_marks => spoken.push_str(word),
            None if symbol == TO.0 => spoken.push_str(TO.1),
            _ if is_symbol(symbol) => spoken.push(' '),
            _ => spoken.push(symbol),
        }
    }
    let words: Vec<&str> = spoken.split(' ').filter(|word| !word.is_empty()).collect();
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_are_words_or_silent() {
        for (text, wanted) in [
            ("⏸ Pause", "Pause"),
            ("Next ▶", "Next"),
            ("✖ line 2: no such key", "error: line 2: no such key"),
            (
                "your mouse → nothing   ·   super-mario",
                "your mouse to nothing super-mario",
            ),
            ("●", ""),
            ("Größe: 3 µm", "Größe: 3 µm"),
        ] {
            assert_eq!(spoken(text, true), wanted);
        }
        assert_eq!(
            spoken("✖ Close the pad window", false),
            "Close the pad window"
        );
    }
}
