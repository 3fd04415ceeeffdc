//! Gamepads as the source, where gelpad was built with them.

use crate::source::Source;

/// A source that is open, and made once it is known whether gelpad has a gamepad of its own: that one, which comes
/// later, must not be among those that play.
pub(super) type Opened = Box<dyn FnOnce(bool) -> Box<dyn Source>>;

/// Opens whatever gamepads and switches are plugged in.
#[cfg(feature = "gilrs")]
pub(super) fn open() -> anyhow::Result<Opened> {
    let gamepads = crate::source::GamepadSource::open()?;
    Ok(Box::new(|own_pad| match own_pad {
        true => Box::new(gamepads.beside_own_pad()),
        false => Box::new(gamepads),
    }))
}

/// Says how to get them.
#[cfg(not(feature = "gilrs"))]
pub(super) fn open() -> anyhow::Result<Opened> {
    anyhow::bail!(
        "this gelpad was built without gamepads\n  help: install libudev-dev and pkg-config, then cargo install --path . --features gilrs"
    )
}
