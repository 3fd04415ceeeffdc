//! macOS: keys and mouse through enigo. Type-checked only; nothing here has run on a Mac.
//!
//! There are no watchers: if gelpad is killed, macOS keeps what is down until the key is pressed again.

mod keyboard;

pub use super::unix::{files, pseudo_terminal, signals, terminal};

use super::ReleaseMethod;
use crate::output::OutputError;

/// Terminals understand colours, and a program opens none.
pub mod console {
    /// Prepares the console for coloured text.
    pub fn prepare() {}

    /// Closes a console that was opened for this program alone.
    pub fn close_own() {}
}

/// What the desktop can show.
pub mod desktop {
    /// Whether windows can be see-through.
    #[must_use]
    pub fn can_be_transparent() -> bool {
        true
    }

    /// Whether a window can open.
    #[must_use]
    pub fn has_display() -> bool {
        true
    }
}

/// What the program keeps of memory that it has freed.
pub mod memory {
    /// The system's allocator returns large blocks.
    pub fn return_freed_blocks() {}
    /// The heap of macOS trims itself.
    pub fn trim_heaps() {}
}

/// The outputs of macOS.
pub mod outputs {
    use super::keyboard::SystemKeyboard;
    use crate::output::OutputError;
    use crate::platform::Candidate;

    /// The gamepad of this system.
    pub const GAMEPAD: Candidate = Candidate {
        name: "a gamepad",
        open: || {
            Err(OutputError::NoDevice {
                device: "gamepad",
                reason: "macOS has no virtual gamepads".to_owned(),
            })
        },
    };

    /// Outputs with keyboard and mouse, best first.
    #[must_use]
    pub fn keyboards() -> Vec<Candidate> {
        vec![Candidate {
            name: "the keyboard",
            open: || Ok(Box::new(SystemKeyboard::connect()?)),
        }]
    }

    /// All outputs, best first.
    #[must_use]
    pub fn all() -> Vec<Candidate> {
        keyboards()
    }
}

/// Names of serial ports: paths of devices.
pub mod ports {
    use std::path::Path;

    use serialport::SerialPortInfo;

    /// The name by which the system lists a port, through links; none if it does not exist.
    #[must_use]
    pub fn listed_name(path: &str) -> Option<String> {
        let real = std::fs::canonicalize(path).ok()?;
        Some(real.to_string_lossy().into_owned())
    }

    /// Whether a port that is not listed may be opened.
    #[must_use]
    pub fn may_exist(path: &str) -> bool {
        Path::new(path).exists()
    }

    /// The ports of this computer.
    #[must_use]
    pub fn all() -> Vec<SerialPortInfo> {
        serialport::available_ports().unwrap_or_default()
    }
}

/// The priority of threads: the system's own.
pub mod priority {
    /// Lets the calling thread run before ordinary programs.
    pub fn raise() {}

    /// Lets ordinary programs run before the calling thread.
    pub fn lower() {}
}

/// Processes of this computer.
pub mod processes {
    use std::borrow::Cow;
    use std::collections::BTreeSet;

    /// A program's name as the list of processes shows it.
    #[must_use]
    pub fn listed_name(name: &str) -> Cow<'_, str> {
        Cow::Borrowed(name)
    }

    /// Names of the running processes: they are not listed here.
    #[must_use]
    pub fn running_names() -> BTreeSet<String> {
        BTreeSet::new()
    }
}

/// Sleeps end on time here without more.
pub mod timer {
    /// Fine sleeps for as long as it lives.
    #[derive(Debug)]
    pub struct FineTimer;

    impl FineTimer {
        /// Requests fine sleeps.
        #[must_use]
        pub fn request() -> Self {
            Self
        }
    }
}

/// Watchers are for other systems.
///
/// # Errors
/// Always.
pub fn run_watcher(_: ReleaseMethod) -> Result<(), OutputError> {
    Err(OutputError::NoDevice {
        device: "watcher",
        reason: "macOS has none".to_owned(),
    })
}
