//! The outputs of each operating system, in order of preference.

use crate::output::{OutputDevice, OutputError};

/// An output that may open.
#[derive(Clone, Copy)]
pub(super) struct Candidate {
    /// Its name in the explanation why it was not chosen.
    pub name: &'static str,
    pub open: fn() -> Result<Box<dyn OutputDevice>, OutputError>,
}

pub(super) use system::{KERNEL, KERNEL_KEYBOARD, desktop};

#[cfg(target_os = "linux")]
mod system {
    use super::Candidate;
    #[cfg(not(feature = "wayland"))]
    use crate::output::OutputError;
    use crate::output::{Uinput, WatchedDevice, X11};

    /// This program, even if its file was replaced after the start.
    const OWN_BINARY: &str = "/proc/self/exe";

    pub(crate) const KERNEL: Candidate = Candidate {
        name: "the kernel's pad and keyboard",
        open: || Ok(Box::new(Uinput::create()?)),
    };
    pub(crate) const KERNEL_KEYBOARD: Candidate = Candidate {
        name: "the kernel's keyboard",
        open: || Ok(Box::new(Uinput::without_pad()?)),
    };
    const X11_DISPLAY: Candidate = Candidate {
        name: "X11",
        open: || {
            Ok(Box::new(WatchedDevice::new(
                X11::connect()?,
                OWN_BINARY.into(),
            )))
        },
    };
    #[cfg(feature = "wayland")]
    const WAYLAND: Candidate = Candidate {
        name: "Wayland",
        open: || {
            let device = crate::output::Wayland::connect()?;
            Ok(Box::new(WatchedDevice::new(device, OWN_BINARY.into())))
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

    /// Outputs that type into this desktop, best first. On Wayland, X11 reaches X11 windows only; without a desktop,
    /// the kernel's keyboard types into the console.
    pub(crate) fn desktop(has_wayland: bool, has_x11: bool) -> Vec<Candidate> {
        match (has_wayland, has_x11) {
            (true, true) => vec![WAYLAND, KERNEL_KEYBOARD, X11_DISPLAY],
            (true, false) => vec![WAYLAND, KERNEL_KEYBOARD],
            (false, true) => vec![X11_DISPLAY],
            (false, false) => vec![KERNEL_KEYBOARD],
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod system {
    use super::Candidate;
    use crate::output::{OutputError, System};

    pub(crate) const KERNEL: Candidate = Candidate {
        name: "a gamepad",
        open: || {
            Err(OutputError::NoDevice {
                device: "gamepad",
                reason: "virtual gamepads need Linux".to_owned(),
            })
        },
    };
    pub(crate) const KERNEL_KEYBOARD: Candidate = KERNEL;

    /// The only desktop output.
    pub(crate) fn desktop(_: bool, _: bool) -> Vec<Candidate> {
        vec![Candidate {
            name: "the keyboard",
            open: || Ok(Box::new(System::connect()?)),
        }]
    }
}
