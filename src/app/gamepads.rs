//! Gamepads as a source, in builds with the feature `gilrs`; what they and a virtual gamepad need on this computer.

use super::AppError;
use crate::source::Source;

/// An opened source. It is completed when the output is known: the argument says whether gelpad's own output is a
/// gamepad, which must not become one of the sources.
pub(super) type OpenSource = Box<dyn FnOnce(bool) -> Box<dyn Source>>;

/// Opens all connected gamepads and switches.
#[cfg(gamepads)]
pub(super) fn open() -> Result<OpenSource, AppError> {
    let gamepads = crate::source::GamepadSource::open()?;
    Ok(Box::new(|own_pad| match own_pad {
        true => Box::new(gamepads.ignoring_own_pad()),
        false => Box::new(gamepads),
    }))
}

/// Explains how to build with gamepads.
#[cfg(not(gamepads))]
pub(super) fn open() -> Result<OpenSource, AppError> {
    Err(AppError::Unsuitable(
        "this gelpad was built without gamepads\n  help: install libudev-dev and pkg-config, then cargo install --path . --features gilrs"
            .to_owned(),
    ))
}

/// One thing that gamepads need on this computer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GamepadCheck {
    /// What was checked, in a few words.
    pub subject: String,
    /// What was found.
    pub found: String,
    /// Whether it works.
    pub works: bool,
    /// The command that fixes it, or what to do.
    pub fix: Option<String>,
}

/// What stands between gelpad and a virtual gamepad or gamepads as a source.
pub(super) fn checks() -> Vec<GamepadCheck> {
    use crate::doctor::{CheckStatus, gamepad_lines};

    let lines = gamepad_lines().into_iter();
    lines
        .map(|line| GamepadCheck {
            subject: line.subject,
            found: line.found,
            works: line.state != CheckStatus::Wrong,
            fix: line.fix,
        })
        .collect()
}
