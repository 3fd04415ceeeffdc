//! Keys of the window toolkit under the names that profiles use.

use crate::types;

/// The output for a key of the window; none for keys that profiles cannot name.
#[must_use]
pub fn output_for_key(key: egui::Key) -> Option<types::Output> {
    let name = match key {
        egui::Key::ArrowLeft => "left".to_owned(),
        egui::Key::ArrowRight => "right".to_owned(),
        egui::Key::ArrowUp => "up".to_owned(),
        egui::Key::ArrowDown => "down".to_owned(),
        egui::Key::PageUp => "page-up".to_owned(),
        egui::Key::PageDown => "page-down".to_owned(),
        egui::Key::Minus => "minus".to_owned(),
        egui::Key::Equals | egui::Key::Plus => "equal".to_owned(),
        egui::Key::OpenBracket => "left-bracket".to_owned(),
        egui::Key::CloseBracket => "right-bracket".to_owned(),
        egui::Key::Semicolon => "semicolon".to_owned(),
        egui::Key::Quote => "apostrophe".to_owned(),
        egui::Key::Backtick => "grave".to_owned(),
        egui::Key::Backslash => "backslash".to_owned(),
        egui::Key::Comma => "comma".to_owned(),
        egui::Key::Period => "period".to_owned(),
        egui::Key::Slash => "slash".to_owned(),
        other => other.name().to_lowercase(),
    };
    name.parse().ok().map(types::Output::Key)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_the_names_of_profiles() {
        for (key, name) in [
            (egui::Key::F, "key:f"),
            (egui::Key::Num7, "key:7"),
            (egui::Key::ArrowLeft, "key:left"),
            (egui::Key::Space, "key:space"),
            (egui::Key::Enter, "key:enter"),
            (egui::Key::F11, "key:f11"),
            (egui::Key::Backspace, "key:backspace"),
            (egui::Key::Comma, "key:comma"),
        ] {
            let output = output_for_key(key).expect(name);
            assert_eq!(output.to_string(), name);
        }
        assert_eq!(output_for_key(egui::Key::F30), None);
    }
}
