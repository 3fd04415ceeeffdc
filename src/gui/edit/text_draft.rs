//! The text of a profile as it is typed, and where it is no TOML. No drawing.

use toml_edit::DocumentMut;

/// The text while it is shown.
#[derive(Clone, Debug, Default)]
pub(super) struct TextDraft {
    pub(super) text: String,
    /// Line, counted from 1, and message of what is no TOML.
    pub(super) error: Option<(usize, String)>,
    pub(super) has_focus: bool,
}

impl TextDraft {
    pub(super) fn new(text: &str) -> Self {
        Self {
            text: text.to_owned(),
            error: syntax_error(text),
            has_focus: false,
        }
    }

    /// The line that is no TOML.
    pub(super) fn broken_line(&self) -> Option<usize> {
        self.error.as_ref().map(|(line, _)| *line)
    }
}

/// Line and message of the first syntax error.
pub(super) fn syntax_error(text: &str) -> Option<(usize, String)> {
    let error = text.parse::<DocumentMut>().err()?;
    let start = error.span().map_or(0, |span| span.start.min(text.len()));
    let line = text.as_bytes()[..start]
        .iter()
        .filter(|byte| **byte == b'\n')
        .count()
        + 1;
    Some((line, error.message().to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_a_syntax_error_is_counted_from_1() {
        let error = syntax_error("name = \"p\"\n\n[[region]\n");
        assert_eq!(error.map(|(line, _)| line), Some(3));
        assert_eq!(syntax_error("name = \"p\"\n"), None);
        assert_eq!(syntax_error("a = ").map(|(line, _)| line), Some(1));
    }
}
