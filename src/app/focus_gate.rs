//! Blocks key output while the gelpad window has the focus: the keys would go to that window.
//!
//! Invariant: every key that was pressed on the device is released on it, blocked or not.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::output::{OutputDevice, OutputError};
use crate::types::{Action, Event, Nanos, Output};

/// An output device whose keys can be blocked.
pub struct FocusGate {
    device: Box<dyn OutputDevice>,
    blocked: Arc<AtomicBool>,
    /// Keys that are down on the device.
    down: Vec<Output>,
    last_ns: Nanos,
}

impl FocusGate {
    /// Wraps a device; the flag blocks its keys while it is set.
    pub fn new(device: Box<dyn OutputDevice>) -> (Self, Arc<AtomicBool>) {
        let blocked = Arc::new(AtomicBool::new(false));
        let gate = Self {
            device,
            blocked: Arc::clone(&blocked),
            down: Vec::new(),
            last_ns: 0,
        };
        (gate, blocked)
    }

    fn release_keys(&mut self) -> Result<(), OutputError> {
        while let Some(output) = self.down.pop() {
            self.device.send(&Event {
                t_ns: self.last_ns,
                action: Action::Release(output),
            })?;
        }
        Ok(())
    }
}

impl OutputDevice for FocusGate {
    fn name(&self) -> &str {
        self.device.name()
    }

    fn supports(&self, output: Output) -> bool {
        self.device.supports(output)
    }

    fn is_gamepad(&self) -> bool {
        self.device.is_gamepad()
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        self.last_ns = event.t_ns;
        let blocked = self.blocked.load(Ordering::Relaxed);
        if blocked {
            self.release_keys()?;
        }
        match event.action {
            Action::Press(output @ Output::Key(_)) => {
                if blocked {
                    return Ok(());
                }
                self.down.push(output);
            }
            Action::Release(output @ Output::Key(_)) => {
                // Already up: its press was blocked, or the focus released it.
                if !self.down.contains(&output) {
                    return Ok(());
                }
                self.down.retain(|down| *down != output);
            }
            _ => {}
        }
        self.device.send(event)
    }

    fn flush(&mut self) -> Result<(), OutputError> {
        if self.blocked.load(Ordering::Relaxed) {
            self.release_keys()?;
        }
        self.device.flush()
    }

    fn idle(&mut self) -> Result<(), OutputError> {
        if self.blocked.load(Ordering::Relaxed) && !self.down.is_empty() {
            self.release_keys()?;
            self.device.flush()?;
        }
        self.device.idle()
    }

    fn rumble(&self) -> [f32; 2] {
        self.device.rumble()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[derive(Default)]
    struct LogDevice(Arc<Mutex<Vec<String>>>);

    impl OutputDevice for LogDevice {
        fn name(&self) -> &str {
            "log"
        }

        fn supports(&self, _: Output) -> bool {
            true
        }

        fn send(&mut self, event: &Event) -> Result<(), OutputError> {
            let line = event.to_string();
            let (_, action) = line.split_once(' ').expect("a time");
            self.0.lock().expect("no panic").push(action.to_owned());
            Ok(())
        }
    }

    fn event(output: &str, press: bool) -> Event {
        let output = output.parse().expect("an output");
        Event {
            t_ns: 1,
            action: if press {
                Action::Press(output)
            } else {
                Action::Release(output)
            },
        }
    }

    #[test]
    fn the_focus_releases_keys_and_blocks_new_presses() {
        let device = LogDevice::default();
        let log = Arc::clone(&device.0);
        let (mut device, blocked) = FocusGate::new(Box::new(device));
        device.send(&event("key:f", true)).expect("sent");
        blocked.store(true, Ordering::Relaxed);
        device.flush().expect("flushed");
        device.send(&event("key:d", true)).expect("blocked");
        device
            .send(&event("pad:a", true))
            .expect("a button, not blocked");
        blocked.store(false, Ordering::Relaxed);
        device.send(&event("key:f", false)).expect("already up");
        device
            .send(&event("key:d", false))
            .expect("its press was blocked");
        device.send(&event("key:d", true)).expect("sent");
        device.send(&event("key:d", false)).expect("sent");
        let log = log.lock().expect("no panic");
        assert_eq!(
            *log,
            [
                "press key:f",
                "release key:f",
                "press pad:a",
                "press key:d",
                "release key:d"
            ]
        );
    }
}
