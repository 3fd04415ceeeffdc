//! The outputs of Windows: its keyboard and mouse.

pub use super::keyboard::is_accepting as accepts_events;

use super::keyboard::WindowsKeyboard;
use super::processes::own_binary;
use crate::output::OutputError;
use crate::platform::Candidate;
use crate::platform::watch::WatchedDevice;

/// The gamepad of this system: it needs a driver, and none of those that exist is maintained, free and signed.
pub const GAMEPAD: Candidate = Candidate {
    name: "a gamepad",
    open: || {
        Err(OutputError::NoDevice {
            device: "gamepad",
            reason:
                "Windows has no virtual gamepads without a driver\n  help: use --output keyboard"
                    .to_owned(),
        })
    },
};

const KEYBOARD: Candidate = Candidate {
    name: "the keyboard",
    open: || {
        Ok(Box::new(WatchedDevice::new(
            WindowsKeyboard::connect(),
            own_binary(),
        )))
    },
};

/// Outputs with keyboard and mouse, best first.
#[must_use]
pub fn keyboards() -> Vec<Candidate> {
    vec![KEYBOARD]
}

/// All outputs, best first.
#[must_use]
pub fn all() -> Vec<Candidate> {
    vec![KEYBOARD]
}
