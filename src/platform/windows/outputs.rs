//! The outputs of Windows: its keyboard and mouse, and a gamepad for people who have the driver ViGEmBus.

pub use super::keyboard::is_accepting as accepts_events;

use super::keyboard::WindowsKeyboard;
use super::processes::own_binary;
use crate::output::{OutputDevice, OutputError};
use crate::platform::Candidate;
use crate::platform::watch::WatchedDevice;

/// The gamepad of this system, with keyboard and mouse.
pub const GAMEPAD: Candidate = Candidate {
    name: "a gamepad",
    open: open_gamepad,
};

const KEYBOARD: Candidate = Candidate {
    name: "the keyboard",
    open: || Ok(open_watched_keyboard()),
};

/// Outputs with keyboard and mouse, best first.
#[must_use]
pub fn keyboards() -> Vec<Candidate> {
    vec![KEYBOARD]
}

/// All outputs, best first. Few people have the driver of the gamepad: where it is missing, it is no candidate.
#[must_use]
pub fn all() -> Vec<Candidate> {
    match gamepad_driver() {
        Ok(()) => vec![GAMEPAD, KEYBOARD],
        Err(_) => vec![KEYBOARD],
    }
}

/// Whether a virtual gamepad can be created.
///
/// # Errors
/// Why not, and what to do.
#[cfg(feature = "vigem")]
pub fn gamepad_driver() -> Result<(), String> {
    super::vigem::find_driver().map_err(|error| error.to_string())
}

/// Whether a virtual gamepad can be created.
///
/// # Errors
/// Why not, and what to do.
#[cfg(not(feature = "vigem"))]
pub fn gamepad_driver() -> Result<(), String> {
    Err("this gelpad was built without it (--features vigem)".to_owned())
}

#[cfg(feature = "vigem")]
fn open_gamepad() -> Result<Box<dyn OutputDevice>, OutputError> {
    let gamepad = super::vigem::Gamepad::plug_in(open_watched_keyboard())?;
    Ok(Box::new(gamepad))
}

#[cfg(not(feature = "vigem"))]
fn open_gamepad() -> Result<Box<dyn OutputDevice>, OutputError> {
    Err(OutputError::NoDevice {
        device: "gamepad",
        reason: "this gelpad was built without the feature `vigem`\n  help: use --output keyboard"
            .to_owned(),
    })
}

fn open_watched_keyboard() -> Box<dyn OutputDevice> {
    Box::new(WatchedDevice::new(WindowsKeyboard::connect(), own_binary()))
}
