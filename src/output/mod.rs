//! Where events go: a device of the system, a trace or TUIO. The devices of each system are in `src/platform/`.
//!
//! Invariant: whatever was pressed is released when an output is dropped, so that a panic or an early return
//! leaves no key down.

mod held;
mod trace;
mod tuio;

pub use held::HeldOutputs;
pub use trace::Trace;
pub use tuio::{Tuio, TuioError};

use crate::types::{Action, Event, Nanos, Output};

/// The reason why an output does not work.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A device cannot be connected to or created.
    #[error("cannot use the output {device}: {reason}")]
    NoDevice {
        /// The device.
        device: &'static str,
        /// The cause, and what to do.
        reason: String,
    },
    /// The reader of the events has ended: a closed pipe.
    #[error("the program that reads the events has closed the pipe")]
    Closed,
    /// An event could not be sent.
    #[error("the {device} refused an event: {reason}")]
    Refused {
        /// The device.
        device: &'static str,
        /// The cause.
        reason: String,
    },
}

/// A device that takes events.
pub trait OutputDevice: Send {
    /// Name of the device, for people.
    fn name(&self) -> &str;

    /// Whether the device has this key or button.
    fn supports(&self, output: Output) -> bool;

    /// Whether other programs, gelpad's own gamepad source among them, see the device as a gamepad.
    fn is_gamepad(&self) -> bool {
        false
    }

    /// Sends one event. It takes effect at the next [`OutputDevice::flush`], or earlier.
    ///
    /// # Errors
    /// The device is gone or refuses the event.
    fn send(&mut self, event: &Event) -> Result<(), OutputError>;

    /// Ends a batch: all events since the last call take effect together.
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

    /// Rumble that the game requests: strong and weak motor, 0..1.
    fn rumble(&self) -> [f32; 2] {
        [0.0; 2]
    }
}

/// The clock of output devices.
#[allow(
    clippy::disallowed_methods,
    reason = "rumble effects, protocol times and the watcher go by the clock"
)]
pub(crate) fn now() -> std::time::Instant {
    std::time::Instant::now()
}

/// A device with a record of what is down on it. Dropping it releases that.
pub struct ReleaseOnDrop {
    device: Box<dyn OutputDevice>,
    down: HeldOutputs,
    /// Time of the last event, ns.
    last_ns: Nanos,
}

impl ReleaseOnDrop {
    /// Wraps a device on which nothing is down.
    #[must_use]
    pub fn new(device: Box<dyn OutputDevice>) -> Self {
        Self {
            device,
            down: HeldOutputs::default(),
            last_ns: 0,
        }
    }

    /// Sends one event and records what is down after it.
    ///
    /// # Errors
    /// See [`OutputDevice::send`].
    pub fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        self.last_ns = event.t_ns;
        // A press counts from the attempt on, a release only once it succeeded: so whatever may be down is
        // released again.
        if let Action::Press(output) = event.action {
            self.down.press(output);
        }
        self.device.send(event)?;
        if let Action::Release(output) = event.action {
            self.down.release(output);
        }
        Ok(())
    }

    /// See [`OutputDevice::flush`].
    ///
    /// # Errors
    /// The device is gone.
    pub fn flush(&mut self) -> Result<(), OutputError> {
        self.device.flush()
    }

    /// See [`OutputDevice::idle`].
    ///
    /// # Errors
    /// The device is gone.
    pub fn idle(&mut self) -> Result<(), OutputError> {
        self.device.idle()
    }

    /// See [`OutputDevice::rumble`].
    #[must_use]
    pub fn rumble(&self) -> [f32; 2] {
        self.device.rumble()
    }
}

impl Drop for ReleaseOnDrop {
    fn drop(&mut self) {
        for output in self.down.take() {
            let event = Event {
                t_ns: self.last_ns,
                action: Action::Release(output),
            };
            match self.device.send(&event) {
                Ok(()) => {}
                // Nobody reads the trace, so no key can stick.
                Err(OutputError::Closed) => return,
                Err(error) => tracing::error!("{output} may still be down: {error}"),
            }
        }
        // An error was already reported for the event that caused it.
        let _ = self.device.flush();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    /// A device that records its events.
    struct RecordingDevice(Arc<Mutex<Vec<String>>>);

    impl OutputDevice for RecordingDevice {
        fn name(&self) -> &str {
            "notes"
        }

        fn supports(&self, _: Output) -> bool {
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
        let device = Box::new(RecordingDevice(Arc::clone(&notes)));
        let press = |name: &str| Event {
            t_ns: 1_000_000,
            action: Action::Press(name.parse().expect("a key")),
        };
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            let mut held = ReleaseOnDrop::new(device);
            held.send(&press("key:f")).expect("sent");
            held.send(&press("key:d")).expect("sent");
            panic!("in the middle of a jump");
        }));
        assert!(result.is_err());
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
