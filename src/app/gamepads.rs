//! Gamepads as a source, in builds with the feature `gilrs`.

use super::AppError;
use crate::source::Source;

/// An opened source. It is completed when the output is known: the argument says whether gelpad's own output is a
/// gamepad, which must not become one of the sources.
pub(super) type OpenSource = Box<dyn FnOnce(bool) -> Box<dyn Source>>;

/// Opens all connected gamepads and switches.
#[cfg(feature = "gilrs")]
pub(super) fn open() -> Result<OpenSource, AppError> {
    let gamepads = crate::source::GamepadSource::open()?;
    Ok(Box::new(|own_pad| match own_pad {
        true => Box::new(gamepads.ignoring_own_pad()),
        false => Box::new(gamepads),
    }))
}

/// Explains how to build with gamepads.
#[cfg(not(feature = "gilrs"))]
pub(super) fn open() -> Result<OpenSource, AppError> {
    Err(AppError::Unsuitable(
        "this gelpad was built without gamepads\n  help: install libudev-dev and pkg-config, then cargo install --path . --features gilrs"
            .to_owned(),
    ))
}
