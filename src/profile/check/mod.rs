//! Reads merged texts as a profile: every value is of its kind and in its range, every name exists.

pub(super) mod binding;
mod macros;
pub(super) mod modes;
mod part;
pub(super) mod region;
pub(super) mod settings;
mod shape;
pub(super) mod top;

use super::diagnostics::Diagnostics;
use super::entries::{Place, Text};
use super::layers::{self, Layers};
use super::reader::Reader;
use super::warn;
use super::{Checked, FindBase, Profile, Source, Texts, find_shipped};
use crate::types::{Method, SourceErrors};

/// Reads and checks a profile, the bases that it extends, and user settings over them.
///
/// # Errors
/// All mistakes, each at its place, in the topmost text that has any.
pub fn read(
    profile: Source,
    user: Option<Source>,
    find: FindBase<'_>,
) -> Result<Checked, SourceErrors> {
    let has_user = user.is_some();
    let Layers {
        sources,
        mut merged,
    } = layers::gather(profile, user, find)?;
    let mut reader = Reader::new(sources.len());
    let vars = std::mem::take(&mut merged.vars);
    reader.substitute(&vars, &mut merged);
    let (mut profile, places) = read_profile(&mut reader, &merged, &sources);
    if let Some(errors) = reader.errors.topmost(&sources) {
        return Err(errors);
    }
    let mut warnings = Diagnostics::new(sources.len());
    warn::check(&profile, &merged, &places, &mut warnings);
    let warnings = warnings.by_text(&sources);
    let texts = sources.iter().map(|source| source.name.clone()).collect();
    let mut chain = sources;
    let user = if has_user { chain.pop() } else { None };
    profile.texts = Texts { chain, user };
    Ok(Checked {
        profile,
        warnings,
        texts,
    })
}

/// The profile, and where each of its bindings was written.
fn read_profile(reader: &mut Reader, text: &Text, sources: &[Source]) -> (Profile, Vec<Place>) {
    let top = &text.top;
    let name = reader.name(top);
    let settings = reader.settings(top);
    let regions = reader.regions(&text.regions);
    let about = reader.text(top, "about");
    let method = reader.parsed::<Method>(top, &top::METHOD);
    let matches = text.matches.as_ref();
    let processes = matches.map_or(Vec::new(), |table| reader.texts(table, "process"));
    let (bindings, places) = reader.bindings(text, &regions);
    reader.refuse_empty(text);
    let profile = Profile {
        name,
        about: about.map_or(String::new(), |(about, _)| about),
        method,
        settings,
        regions,
        parts: std::mem::take(&mut reader.parts),
        outputs: std::mem::take(&mut reader.outputs),
        layers: std::mem::take(&mut reader.layers),
        bindings,
        processes: processes.into_iter().map(|(text, _)| text).collect(),
        origins: top::origins(text, sources),
        texts: Texts::default(),
    };
    (profile, places)
}

impl Texts {
    /// Reads them again.
    ///
    /// # Errors
    /// As [`read`].
    pub fn read(&self) -> Result<Checked, SourceErrors> {
        let Some((own, bases)) = self.chain.split_last() else {
            return Err(SourceErrors::new("profile", "", vec![]));
        };
        // Each text extends the one below it, whatever that was called.
        let left = std::cell::Cell::new(bases);
        let find = |name: &str| match left.get().split_last() {
            Some((base, below)) => {
                left.set(below);
                Ok(base.clone())
            }
            None => Err(format!("the text of `{name}` is missing")),
        };
        read(own.clone(), self.user.clone(), &find)
    }
}

impl Profile {
    /// Reads a profile that extends shipped ones only; `name` stands for the file in messages.
    ///
    /// # Errors
    /// All mistakes in the text, each at its place.
    pub fn from_toml(name: &str, text: &str) -> Result<Self, SourceErrors> {
        let source = Source {
            name: name.to_owned(),
            toml: text.to_owned(),
        };
        read(source, None, &find_shipped).map(|checked| checked.profile)
    }
}
