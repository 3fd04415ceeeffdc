//! How an image is made: a word in pads, profiles and on the command line.

use std::fmt;
use std::str::FromStr;

use serde::Deserialize;

/// How an image is made from relative voltage changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// One step, prior: identity.
    Tikhonov,
    /// One step, prior: the inverse root of each pixel's sensitivity, which evens out depth.
    #[default]
    Noser,
    /// One step, prior: neighbouring pixels change alike.
    Smooth,
    /// Least squares with few pixels changed: the sum of their absolute values is the penalty.
    L1,
}

impl Method {
    /// All of them.
    pub const ALL: &[Self] = &[Self::Tikhonov, Self::Noser, Self::Smooth, Self::L1];

    /// The word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Tikhonov => "tikhonov",
            Self::Noser => "noser",
            Self::Smooth => "smooth",
            Self::L1 => "l1",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Method {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = || Self::ALL.iter().map(|method| method.name());
        Self::ALL
            .iter()
            .copied()
            .find(|method| method.name() == text)
            .ok_or_else(|| format!("the methods are {}", known().collect::<Vec<_>>().join(", ")))
    }
}
