//! The time diagram of a gesture or a mode: its lines in the guide, so that there is one of each.

/// The guide to profiles.
const GUIDE: &str = include_str!("../../../docs/profiles.md");

/// The diagram of a gesture: the first block of its section, without the lines of other gestures. Empty for an unknown word.
#[must_use]
pub(super) fn gesture_diagram(gesture: &str, all: &[&str]) -> String {
    let names = |heading: &str| {
        let words = heading.split([' ', ',', ':', '#', '(', ')']);
        words.into_iter().any(|word| word == gesture)
    };
    let mut lines = GUIDE.lines();
    if !lines.any(|line| line.starts_with("### ") && names(line)) {
        return String::new();
    }
    block(lines, |word| word == gesture || !all.contains(&word))
}

/// The diagram of a mode: the gesture above, the output below. Empty for a mode without one.
#[must_use]
pub(super) fn mode_diagram(mode: &str) -> String {
    let mut lines = GUIDE.lines();
    if !lines.any(|line| line == "## Outputs and modes") {
        return String::new();
    }
    let diagram = block(lines, |word| word == mode || word == "gesture");
    match diagram.lines().count() {
        2.. => diagram,
        _ => String::new(),
    }
}

/// The lines of the next block of text whose first word is wanted.
fn block<'a>(lines: impl Iterator<Item = &'a str>, is_wanted: impl Fn(&str) -> bool) -> String {
    let first_word = |line: &'a str| line.split(' ').next().unwrap_or_default();
    let block: Vec<&str> = lines
        .skip_while(|line| *line != "```text")
        .skip(1)
        .take_while(|line| *line != "```")
        .filter(|line| is_wanted(first_word(line)))
        .collect();
    block.join("\n")
}

/// Takes the notes at the ends of lines out of a diagram: the drawing, and a line for each note. A note has several words.
#[must_use]
pub(super) fn split_notes(diagram: &str) -> (String, String) {
    let (mut drawing, mut notes) = (Vec::new(), Vec::new());
    for line in diagram.lines() {
        let note = line.rsplit_once("   ").filter(|(before, note)| {
            let is_text = note.starts_with(char::is_alphabetic) && note.contains(' ');
            is_text && !before.trim().is_empty()
        });
        let Some((before, note)) = note else {
            drawing.push(line);
            continue;
        };
        drawing.push(before.trim_end());
        let name = before.split(' ').find(|word| !word.is_empty());
        let name = name.filter(|name| name.starts_with(char::is_alphabetic));
        notes.push(match name {
            Some(name) => format!("{name}: {note}"),
            None => note.to_owned(),
        });
    }
    (drawing.join("\n"), notes.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{KeyKind, keys};

    /// The words of a key of bindings.
    fn words(name: &str) -> &'static [&'static str] {
        let key = keys().iter().find(|key| key.name == name);
        match key.expect("a key").kind {
            KeyKind::Word(words) => words,
            kind => panic!("{kind:?}"),
        }
    }

    #[test]
    fn every_gesture_has_a_diagram() {
        let all = words("gesture");
        for gesture in all {
            let diagram = gesture_diagram(gesture, all);
            assert!(diagram.lines().count() >= 2, "{gesture}: {diagram}");
        }
        let hold = gesture_diagram("hold", all);
        assert!(
            hold.contains("hold_ms") && !hold.contains("double-tap"),
            "{hold}"
        );
    }

    #[test]
    fn notes_leave_drawings_that_fit_into_the_panel() {
        let all = words("gesture");
        let gestures = all.iter().map(|gesture| gesture_diagram(gesture, all));
        let modes = words("mode").iter().map(|mode| mode_diagram(mode));
        for diagram in gestures.chain(modes) {
            let (drawing, notes) = split_notes(&diagram);
            let widest = drawing.lines().map(|line| line.chars().count()).max();
            assert!(widest.unwrap_or(0) <= 66, "{drawing}");
            assert!(!notes.contains("__"), "no part of a drawing: {notes}");
            assert_eq!(drawing.lines().count(), diagram.lines().count());
        }
        let force = split_notes(&gesture_diagram("force", all));
        assert!(force.1.starts_with("force: a level; it is"), "{force:?}");
    }

    #[test]
    fn every_mode_but_a_macro_has_a_diagram() {
        for mode in words("mode").iter().filter(|mode| **mode != "macro") {
            assert_eq!(mode_diagram(mode).lines().count(), 2, "{mode}");
        }
    }
}
