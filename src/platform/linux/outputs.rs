//! The outputs of Linux, in order of preference.

use super::processes::own_binary;
use super::uinput::Uinput;
use super::x11::X11;
use crate::output::OutputError;
use crate::platform::Candidate;
use crate::platform::watch::WatchedDevice;

const KERNEL: Candidate = Candidate {
    name: "the kernel's pad and keyboard",
    open: || Ok(Box::new(Uinput::create()?)),
};
const KERNEL_KEYBOARD: Candidate = Candidate {
    name: "the kernel's keyboard",
    open: || Ok(Box::new(Uinput::without_pad()?)),
};
const X11_DISPLAY: Candidate = Candidate {
    name: "X11",
    open: || Ok(Box::new(WatchedDevice::new(X11::connect()?, own_binary()))),
};
#[cfg(feature = "wayland")]
const WAYLAND: Candidate = Candidate {
    name: "Wayland",
    open: || {
        let device = super::wayland::Wayland::connect()?;
        Ok(Box::new(WatchedDevice::new(device, own_binary())))
    },
};
#[cfg(not(feature = "wayland"))]
const WAYLAND: Candidate = Candidate {
    name: "Wayland",
    open: || {
        Err(OutputError::NoDevice {
            device: "Wayland",
            reason: "this gelpad was built without the feature `wayland`".to_owned(),
        })
    },
};

const NO_DESKTOP: Candidate = Candidate {
    name: "a desktop",
    open: || {
        Err(OutputError::NoDevice {
            device: "desktop",
            reason: "neither WAYLAND_DISPLAY nor DISPLAY is set".to_owned(),
        })
    },
};

/// The gamepad of this system.
pub const GAMEPAD: Candidate = KERNEL;

/// Outputs with keyboard and mouse, best first: of the desktop, or of the kernel without a desktop.
#[must_use]
pub fn keyboards() -> Vec<Candidate> {
    let (has_wayland, has_x11) = displays();
    let mut candidates = desktop(has_wayland, has_x11);
    if !has_wayland && !has_x11 {
        candidates.insert(0, NO_DESKTOP);
    }
    candidates
}

/// All outputs, best first. Devices of the kernel reach every program, and the kernel releases their keys; then the desktop's own.
#[must_use]
pub fn all() -> Vec<Candidate> {
    let (has_wayland, has_x11) = displays();
    let mut candidates = vec![KERNEL];
    if has_wayland || has_x11 {
        let others = desktop(has_wayland, has_x11).into_iter();
        // If the kernel's gamepad cannot be created, its keyboard cannot either.
        candidates.extend(others.filter(|one| one.name != KERNEL_KEYBOARD.name));
    } else {
        candidates.push(NO_DESKTOP);
    }
    candidates
}

/// Whether there is a Wayland and an X11 display.
fn displays() -> (bool, bool) {
    let is_set = |variable: &str| std::env::var_os(variable).is_some_and(|value| !value.is_empty());
    (is_set("WAYLAND_DISPLAY"), is_set("DISPLAY"))
}

/// Outputs that type into this desktop, best first. On Wayland, X11 reaches X11 windows only; without a desktop,
/// the kernel's keyboard types into the console.
fn desktop(has_wayland: bool, has_x11: bool) -> Vec<Candidate> {
    match (has_wayland, has_x11) {
        (true, true) => vec![WAYLAND, KERNEL_KEYBOARD, X11_DISPLAY],
        (true, false) => vec![WAYLAND, KERNEL_KEYBOARD],
        (false, true) => vec![X11_DISPLAY],
        (false, false) => vec![KERNEL_KEYBOARD],
    }
}
