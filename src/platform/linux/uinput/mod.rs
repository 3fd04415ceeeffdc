//! Devices of the Linux kernel, created through `/dev/uinput`: gamepad, keyboard and mouse.
//!
//! They work in every program, with any display. When gelpad ends, however it ends, the kernel removes the
//! devices and releases what is down: no watcher is needed.
//!
//! Invariant: a batch of events is one report for each device (one `SYN_REPORT`), so that no reader sees half
//! of a state. A key or button that changes twice in a batch gets two reports.

mod keyboard;
mod mouse;
mod pad;
mod report;
mod rumble;

use std::io;

use evdev::uinput::{VirtualDevice, VirtualDeviceBuilder};

use crate::output::{OutputDevice, OutputError};
use crate::types::{Action, Event, Output};
use keyboard::Keyboard;
use mouse::Mouse;
use pad::Pad;
pub use pad::{PAD_NAME, PAD_PRODUCT, PAD_VENDOR, PAD_VERSION};
use report::Report;

/// The file through which devices are created.
pub const UINPUT: &str = "/dev/uinput";

/// The reason why no device can be created.
#[derive(Debug, thiserror::Error)]
pub enum UinputError {
    /// The file is missing or has no driver.
    #[error("the kernel module uinput is not loaded: run `sudo modprobe uinput`")]
    NoModule,
    /// This user may not write to it.
    #[error("no permission to write {UINPUT}: run `gelpad doctor --install-rule`")]
    NoPermission,
    /// Another error.
    #[error("{UINPUT}: {0}")]
    Other(#[source] io::Error),
}

impl From<io::Error> for UinputError {
    fn from(error: io::Error) -> Self {
        use rustix::io::Errno;

        match Errno::from_io_error(&error) {
            Some(Errno::NOENT | Errno::NODEV | Errno::NXIO) => Self::NoModule,
            Some(Errno::ACCESS | Errno::PERM) => Self::NoPermission,
            _ => Self::Other(error),
        }
    }
}

impl From<UinputError> for OutputError {
    fn from(error: UinputError) -> Self {
        let reason = error.to_string();
        Self::NoDevice {
            device: "uinput",
            reason,
        }
    }
}

/// A gamepad, a keyboard and a mouse, which one profile may use together.
///
/// They are created at the start and exist until this is dropped: games do not notice a gamepad that appears later.
pub struct Uinput {
    name: &'static str,
    pad: Option<Pad>,
    keyboard: Keyboard,
    mouse: Mouse,
}

impl Uinput {
    /// Creates all three.
    ///
    /// # Errors
    /// No module, no permission, or the kernel refuses.
    pub fn create() -> Result<Self, UinputError> {
        Ok(Self {
            name: "gamepad, keyboard and mouse of the kernel",
            pad: Some(Pad::create()?),
            keyboard: Keyboard::create()?,
            mouse: Mouse::create()?,
        })
    }

    /// Creates a keyboard and a mouse.
    ///
    /// # Errors
    /// No module, no permission, or the kernel refuses.
    pub fn without_pad() -> Result<Self, UinputError> {
        Ok(Self {
            name: "keyboard and mouse of the kernel",
            pad: None,
            keyboard: Keyboard::create()?,
            mouse: Mouse::create()?,
        })
    }
}

impl OutputDevice for Uinput {
    fn name(&self) -> &str {
        self.name
    }

    fn supports(&self, output: Output) -> bool {
        match output {
            Output::Key(_) | Output::Mouse(_) => true,
            Output::Button(_) => self.pad.is_some(),
        }
    }

    fn is_gamepad(&self) -> bool {
        self.pad.is_some()
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        let result = match event.action {
            Action::Press(Output::Key(key)) => self.keyboard.key(key, true),
            Action::Release(Output::Key(key)) => self.keyboard.key(key, false),
            Action::Press(Output::Mouse(button)) => self.mouse.button(button, true),
            Action::Release(Output::Mouse(button)) => self.mouse.button(button, false),
            Action::Motion { dx, dy } => self.mouse.motion(dx, dy),
            Action::Wheel { dx, dy } => self.mouse.wheel(dx, dy),
            Action::Press(Output::Button(_))
            | Action::Release(Output::Button(_))
            | Action::Axis(..) => match &mut self.pad {
                Some(pad) => pad.add(&event.action),
                None => Ok(()),
            },
        };
        result.map_err(refused)
    }

    fn flush(&mut self) -> Result<(), OutputError> {
        if let Some(pad) = &mut self.pad {
            pad.flush().map_err(refused)?;
        }
        self.keyboard.flush().map_err(refused)?;
        self.mouse.flush().map_err(refused)
    }

    fn rumble(&self) -> [f32; 2] {
        self.pad.as_ref().map_or([0.0; 2], Pad::rumble)
    }
}

fn builder<'a>() -> io::Result<VirtualDeviceBuilder<'a>> {
    VirtualDevice::builder()
}

fn refused(error: io::Error) -> OutputError {
    OutputError::Refused {
        device: "uinput",
        reason: error.to_string(),
    }
}
