//! A mistake in a text that a user wrote (a pad, a profile, a script), with the place where it is.
//!
//! The core finds mistakes but does not print; a face renders them under the user's own lines.

use std::fmt;
use std::ops::Range;

/// One mistake.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Bytes of the text that are wrong.
    pub span: Range<usize>,
    /// What is wrong, as a sentence without a full stop.
    pub message: String,
    /// A few words that stand under the place.
    pub label: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl Fault {
    /// A fault at a place.
    pub fn new(span: Range<usize>, message: impl Into<String>, label: impl Into<String>) -> Self {
        Self {
            span,
            message: message.into(),
            label: label.into(),
            help: None,
        }
    }

    /// The same fault with advice.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// A text that cannot be used, with everything that is wrong with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Faulty {
    /// The file's name, or what stands for it.
    pub name: String,
    /// The whole text.
    pub text: String,
    /// What is wrong, in the order of the text; never empty.
    pub faults: Vec<Fault>,
}

impl Faulty {
    /// Gathers the faults of a text in the order in which they stand there.
    #[must_use]
    pub fn new(name: &str, text: &str, mut faults: Vec<Fault>) -> Self {
        faults.sort_by_key(|fault| (fault.span.start, fault.span.end));
        Self {
            name: name.to_owned(),
            text: text.to_owned(),
            faults,
        }
    }

    /// Wraps what the TOML parser refused.
    #[must_use]
    pub fn from_toml(name: &str, text: &str, error: &toml::de::Error) -> Self {
        let span = error.span().unwrap_or(0..0);
        let said = error.message().trim().replace('\n', ", ");
        let said = said
            .replace("expected f64", "expected a number, without quotes")
            .replace("expected i64", "expected a whole number, without quotes");
        let fault = if said.starts_with("missing field") {
            Fault::new(span, said, "missing in what begins here")
        } else {
            Fault::new(span, said, "here")
        };
        Self::new(name, text, vec![fault])
    }

    /// Line and column of a byte, both from 1; columns count characters.
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

impl fmt::Display for Faulty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, fault) in self.faults.iter().enumerate() {
            let (line, column) = self.line_column(fault.span.start);
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{}:{line}:{column}: {}", self.name, fault.message)?;
        }
        Ok(())
    }
}

impl std::error::Error for Faulty {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_lines_and_characters_from_one() {
        let text = "a\nbä x\n";
        let faulty = Faulty::new("f.toml", text, vec![Fault::new(6..7, "no", "here")]);
        assert_eq!(faulty.to_string(), "f.toml:2:4: no");
        assert_eq!(faulty.line_column(text.len() + 5), (3, 1));
    }
}
