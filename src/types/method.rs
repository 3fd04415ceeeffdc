//! Reconstruction methods, as named in pads, profiles and on the command line.

use std::fmt;
use std::str::FromStr;

use serde::Deserialize;

/// A method that reconstructs an image from relative voltage changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// One step with the identity as prior.
    Tikhonov,
    /// One step with the inverse root of each pixel's sensitivity as prior, which compensates for depth.
    #[default]
    Noser,
    /// One step with a prior of similar neighbouring pixels.
    Smooth,
    /// Least squares with the sum of absolute values as penalty: few pixels change.
    L1,
}

impl Method {
    /// All methods.
    pub const ALL: &[Self] = &[Self::Tikhonov, Self::Noser, Self::Smooth, Self::L1];

    /// The name.
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
