//! The texts that a profile is read from.

/// A text and the name that messages give it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The file's name, or what stands for it.
    pub name: String,
    /// The text.
    pub toml: String,
}

/// The texts that a profile was read from: enough to read it again without any file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Texts {
    /// The bases that it extends, the lowest first, and last its own text.
    pub chain: Vec<Source>,
    /// User settings over it.
    pub user: Option<Source>,
}

/// Finds the text that `extends` names.
pub type FindBase<'a> = &'a dyn Fn(&str) -> Result<Source, String>;
