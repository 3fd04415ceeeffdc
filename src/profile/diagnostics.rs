//! Mistakes and warnings, kept apart by the text in which they stand.

use super::entries::Place;
use super::sources::Source;
use crate::types::{Diagnostic, SourceErrors};

/// More diagnostics of one text are dropped: nobody reads them, and comparing them takes time.
const MOST_DIAGNOSTICS: usize = 500;

/// Diagnostics of each text of a profile.
#[derive(Debug)]
pub(super) struct Diagnostics(Vec<Vec<Diagnostic>>);

impl Diagnostics {
    pub(super) fn new(layers: usize) -> Self {
        Self(vec![Vec::new(); layers])
    }

    pub(super) fn push(&mut self, place: &Place, message: impl Into<String>, label: &str) {
        self.add(place, Diagnostic::new(place.span.clone(), message, label));
    }

    pub(super) fn help(
        &mut self,
        place: &Place,
        message: impl Into<String>,
        label: &str,
        help: impl Into<String>,
    ) {
        self.add(
            place,
            Diagnostic::new(place.span.clone(), message, label).help(help),
        );
    }

    fn add(&mut self, place: &Place, diagnostic: Diagnostic) {
        let known = &mut self.0[place.layer];
        // A value that two places use is reported once.
        if known.len() < MOST_DIAGNOSTICS && !known.contains(&diagnostic) {
            known.push(diagnostic);
        }
    }

    /// Whether something was reported about exactly this place.
    pub(super) fn contains(&self, place: &Place) -> bool {
        let mut spans = self.0[place.layer].iter().map(|known| &known.span);
        spans.any(|span| *span == place.span)
    }

    /// Those of the topmost text that has any: the text that is being edited.
    pub(super) fn topmost(&mut self, sources: &[Source]) -> Option<SourceErrors> {
        let layer = self.0.iter().rposition(|list| !list.is_empty())?;
        let source = &sources[layer];
        let list = std::mem::take(&mut self.0[layer]);
        Some(SourceErrors::new(&source.name, &source.toml, list))
    }

    /// One entry for each text that has any.
    pub(super) fn by_text(self, sources: &[Source]) -> Vec<SourceErrors> {
        sources
            .iter()
            .zip(self.0)
            .filter(|(_, list)| !list.is_empty())
            .map(|(source, list)| SourceErrors::new(&source.name, &source.toml, list))
            .collect()
    }
}
