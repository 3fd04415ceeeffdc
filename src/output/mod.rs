//! Where events go: devices of the kernel, the keyboard and mouse of this desktop, or a trace.
//!
//! Invariant: whatever was pressed is released when an output is dropped, so that a panic or an early return leaves
//! no key down.

#[cfg(any(windows, target_os = "macos"))]
mod system;
mod trace;
mod tuio;
#[cfg(target_os = "linux")]
pub mod uinput;
#[cfg(target_os = "linux")]
pub mod watch;
#[cfg(all(target_os = "linux", feature = "wayland"))]
mod wayland;
#[cfg(target_os = "linux")]
mod x11;

#[cfg(any(windows, target_os = "macos"))]
pub use system::System;
pub use trace::Trace;
pub use tuio::{Tuio, TuioError};
#[cfg(target_os = "linux")]
pub use uinput::Uinput;
#[cfg(target_os = "linux")]
pub use watch::Watched;
#[cfg(all(target_os = "linux", feature = "wayland"))]
pub use wayland::Wayland;
#[cfg(target_os = "linux")]
pub use x11::X11;

use crate::types::{Action, Event, Output};

/// Why an output does not work.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A device cannot be reached or made.
    #[error("no output by {device}: {reason}")]
    NoDevice {
        /// Which.
        device: &'static str,
        /// Why, and what to do.
        reason: String,
    },
    /// Whoever read the events has gone: a closed pipe.
    #[error("nobody reads the events any more")]
    Closed,
    /// An event could not be sent.
    #[error("the {device} did not take an event: {reason}")]
    Refused {
        /// Which device.
        device: &'static str,
        /// Why.
        reason: String,
    },
}

/// A device that takes events.
pub trait Device: Send {
    /// What it is, for the player.
    fn name(&self) -> &str;

    /// Whether it has such a key or button.
    fn takes(&self, output: Output) -> bool;

    /// Whether other programs see it as a gamepad, gelpad's own source among them.
    fn is_gamepad(&self) -> bool {
        false
    }

    /// Takes one event. It shows at the next [`Device::flush`], or sooner.
    ///
    /// # Errors
    /// The device is gone or refuses.
    fn send(&mut self, event: &Event) -> Result<(), OutputError>;

    /// What was sent is one whole state: shows it, all at once.
    ///
    /// # Errors
    /// The device is gone.
    fn flush(&mut self) -> Result<(), OutputError> {
        Ok(())
    }

    /// Called between events, many times a second.
    ///
    /// # Errors
    /// The device is gone.
    fn idle(&mut self) -> Result<(), OutputError> {
        Ok(())
    }

    /// How hard a game shakes it: the strong motor and the weak one, 0..1.
    fn rumble(&self) -> [f32; 2] {
        [0.0; 2]
    }
}

/// A device, and what is down on it. Dropping it releases that.
pub struct Held {
    device: Box<dyn Device>,
    down: Vec<Output>,
    last: Event,
}

impl Held {
    /// Wraps a device on which nothing is down.
    #[must_use]
    pub fn new(device: Box<dyn Device>) -> Self {
        let nothing = Event {
            t_ns: 0,
            action: Action::Axis(crate::types::Axis::LeftX, 0.0),
        };
        Self {
            device,
            down: Vec::new(),
            last: nothing,
        }
    }

    /// Carries out one event and remembers what it left down.
    ///
    /// # Errors
    /// See [`Device::send`].
    pub fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        self.last = *event;
        // A press counts as soon as it is tried, a release only once it is done: whatever may be down is released again.
        if let Action::Press(output) = event.action {
            self.down.push(output);
        }
        self.device.send(event)?;
        if let Action::Release(output) = event.action {
            self.down.retain(|down| *down != output);
        }
        Ok(())
    }

    /// See [`Device::flush`].
    ///
    /// # Errors
    /// The device is gone.
    pub fn flush(&mut self) -> Result<(), OutputError> {
        self.device.flush()
    }

    /// See [`Device::idle`].
    ///
    /// # Errors
    /// The device is gone.
    pub fn idle(&mut self) -> Result<(), OutputError> {
        self.device.idle()
    }

    /// See [`Device::rumble`].
    #[must_use]
    pub fn rumble(&self) -> [f32; 2] {
        self.device.rumble()
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        for output in std::mem::take(&mut self.down) {
            let event = Event {
                t_ns: self.last.t_ns,
                action: Action::Release(output),
            };
            match self.device.send(&event) {
                Ok(()) => {}
                // Nobody reads the trace: there is no key that could stick.
                Err(OutputError::Closed) => return,
                Err(error) => tracing::error!("{output} may still be down: {error}"),
            }
        }
        // What could not be flushed was told when it was sent.
        let _ = self.device.flush();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    /// A device that notes what it is told.
    struct Notes(Arc<Mutex<Vec<String>>>);

    impl Device for Notes {
        fn name(&self) -> &str {
            "notes"
        }

        fn takes(&self, _: Output) -> bool {
            true
        }

        fn send(&mut self, event: &Event) -> Result<(), OutputError> {
            self.0.lock().expect("notes").push(event.to_string());
            Ok(())
        }
    }

    #[test]
    fn a_panic_leaves_no_key_down() {
        let notes = Arc::new(Mutex::new(Vec::new()));
        let device = Box::new(Notes(Arc::clone(&notes)));
        let press = |name: &str| Event {
            t_ns: 1_000_000,
            action: Action::Press(name.parse().expect("a key")),
        };
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            let mut held = Held::new(device);
            held.send(&press("key:f")).expect("sent");
            held.send(&press("key:d")).expect("sent");
            panic!("in the middle of a jump");
        }));
        assert!(outcome.is_err());
        assert_eq!(
            *notes.lock().expect("notes"),
            [
                "1.000 press key:f",
                "1.000 press key:d",
                "1.000 release key:f",
                "1.000 release key:d"
            ]
        );
    }
}
