//! A line of the report.

/// How something is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// As it should be.
    Ok,
    /// Worth knowing, and no fault.
    Note,
    /// Not as it should be; there is a command that mends it.
    Wrong,
}

/// What was found about one thing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// How it is.
    pub state: State,
    /// What it is about, a few words.
    pub subject: String,
    /// What was found, half a sentence.
    pub found: String,
    /// The command that mends it, or what to do.
    pub mend: Option<String>,
}

impl Line {
    pub(super) fn ok(subject: &str, found: impl Into<String>) -> Self {
        Self::new(State::Ok, subject, found)
    }

    pub(super) fn note(subject: &str, found: impl Into<String>) -> Self {
        Self::new(State::Note, subject, found)
    }

    pub(super) fn wrong(subject: &str, found: impl Into<String>, mend: impl Into<String>) -> Self {
        Self::new(State::Wrong, subject, found).mend(mend)
    }

    pub(super) fn mend(mut self, mend: impl Into<String>) -> Self {
        self.mend = Some(mend.into());
        self
    }

    fn new(state: State, subject: &str, found: impl Into<String>) -> Self {
        Self {
            state,
            subject: subject.to_owned(),
            found: found.into(),
            mend: None,
        }
    }
}
