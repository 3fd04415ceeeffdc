//! Mistakes in files that users write (pads, profiles, scripts), with their places in the text.
//!
//! The core reports them; window and command line render them with the lines of the file.

use std::fmt;
use std::ops::Range;

/// One mistake.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// The wrong part of the text, in bytes.
    pub span: Range<usize>,
    /// What is wrong: a sentence without full stop.
    pub message: String,
    /// A few words for the place itself.
    pub label: String,
    /// How to correct it.
    pub help: Option<String>,
}

impl Diagnostic {
    /// A mistake at a place.
    pub fn new(span: Range<usize>, message: impl Into<String>, label: impl Into<String>) -> Self {
        Self {
            span,
            message: message.into(),
            label: label.into(),
            help: None,
        }
    }

    /// Adds how to correct it.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// A text with its mistakes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceErrors {
    /// Name of the file.
    pub name: String,
    /// The whole text.
    pub text: String,
    /// The mistakes in the order of the text; at least one.
    pub diagnostics: Vec<Diagnostic>,
}

impl SourceErrors {
    /// Sorts the mistakes of a text by their place.
    #[must_use]
    pub fn new(name: &str, text: &str, mut diagnostics: Vec<Diagnostic>) -> Self {
        diagnostics.sort_by_key(|one| (one.span.start, one.span.end));
        Self {
            name: name.to_owned(),
            text: text.to_owned(),
            diagnostics,
        }
    }

    /// Wraps an error of the TOML parser.
    #[must_use]
    pub fn from_toml(name: &str, text: &str, error: &toml::de::Error) -> Self {
        let span = error.span().unwrap_or(0..0);
        let message = error
            .message()
            .trim()
            .replace('\n', ", ")
            .replace("expected f64", "expected a number, without quotes")
            .replace("expected i64", "expected a whole number, without quotes");
        let label = match message.starts_with("missing field") {
            true => "missing in this table",
            false => "here",
        };
        Self::new(name, text, vec![Diagnostic::new(span, message, label)])
    }

    /// Line and column of a byte, both counted from 1; columns count characters.
    #[must_use]
    pub fn line_column(&self, byte: usize) -> (usize, usize) {
        let mut end = byte.min(self.text.len());
        while !self.text.is_char_boundary(end) {
            end -= 1;
        }
        let before = &self.text[..end];
        let line = before.matches('\n').count() + 1;
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (line, before[start..].chars().count() + 1)
    }
}

impl fmt::Display for SourceErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, diagnostic) in self.diagnostics.iter().enumerate() {
            let (line, column) = self.line_column(diagnostic.span.start);
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{}:{line}:{column}: {}", self.name, diagnostic.message)?;
        }
        Ok(())
    }
}

impl std::error::Error for SourceErrors {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_are_counted_from_one() {
        let text = "a\nbä x\n";
        let errors = SourceErrors::new("f.toml", text, vec![Diagnostic::new(6..7, "no", "here")]);
        assert_eq!(errors.to_string(), "f.toml:2:4: no");
        assert_eq!(errors.line_column(text.len() + 5), (3, 1));
    }
}
