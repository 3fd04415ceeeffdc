//! The result of one check.

/// Outcome of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CheckStatus {
    /// Works.
    Ok,
    /// Information, not a fault.
    Note,
    /// A fault; [`CheckLine::fix`] names its fix.
    Wrong,
}

/// Result of one check: a line of the report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CheckLine {
    /// Outcome.
    pub state: CheckStatus,
    /// What was checked, in a few words.
    pub subject: String,
    /// What was found.
    pub found: String,
    /// The command that fixes it, or what to do.
    pub fix: Option<String>,
}

impl CheckLine {
    pub(super) fn ok(subject: &str, found: impl Into<String>) -> Self {
        Self::new(CheckStatus::Ok, subject, found)
    }

    pub(super) fn note(subject: &str, found: impl Into<String>) -> Self {
        Self::new(CheckStatus::Note, subject, found)
    }

    pub(super) fn wrong(subject: &str, found: impl Into<String>, fix: impl Into<String>) -> Self {
        Self::new(CheckStatus::Wrong, subject, found).with_fix(fix)
    }

    pub(super) fn with_fix(mut self, fix: impl Into<String>) -> Self {
        self.fix = Some(fix.into());
        self
    }

    fn new(state: CheckStatus, subject: &str, found: impl Into<String>) -> Self {
        Self {
            state,
            subject: subject.to_owned(),
            found: found.into(),
            fix: None,
        }
    }
}
