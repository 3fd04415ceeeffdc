//! A keyboard that keeps quiet while the window has the focus: its keys would come back to us.
//!
//! Invariant: what went down on the device comes up on it, hushed or not.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::output::{Device, OutputError};
use crate::types::{Action, Event, Nanos, Output};

/// A device whose keys can be held back.
pub struct Hushed {
    device: Box<dyn Device>,
    hush: Arc<AtomicBool>,
    /// Keys that are down on the device.
    down: Vec<Output>,
    last_ns: Nanos,
}

impl Hushed {
    /// Wraps a device, and gives what holds its keys back.
    #[must_use]
    pub fn new(device: Box<dyn Device>) -> (Self, Arc<AtomicBool>) {
        let hush = Arc::new(AtomicBool::new(false));
        let hushed = Self {
            device,
            hush: Arc::clone(&hush),
            down: Vec::new(),
            last_ns: 0,
        };
        (hushed, hush)
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

impl Device for Hushed {
    fn name(&self) -> &str {
        self.device.name()
    }

    fn takes(&self, output: Output) -> bool {
        self.device.takes(output)
    }

    fn is_gamepad(&self) -> bool {
        self.device.is_gamepad()
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        self.last_ns = event.t_ns;
        let hushed = self.hush.load(Ordering::Relaxed);
        if hushed {
            self.release_keys()?;
        }
        match event.action {
            Action::Press(output @ Output::Key(_)) => {
                if hushed {
                    return Ok(());
                }
                self.down.push(output);
            }
            Action::Release(output @ Output::Key(_)) => {
                // A key that was held back, or let go when the focus came, is up.
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
        if self.hush.load(Ordering::Relaxed) {
            self.release_keys()?;
        }
        self.device.flush()
    }

    fn idle(&mut self) -> Result<(), OutputError> {
        if self.hush.load(Ordering::Relaxed) && !self.down.is_empty() {
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
    struct Seen(Arc<Mutex<Vec<String>>>);

    impl Device for Seen {
        fn name(&self) -> &str {
            "seen"
        }

        fn takes(&self, _: Output) -> bool {
            true
        }

        fn send(&mut self, event: &Event) -> Result<(), OutputError> {
            let words = event.to_string();
            let (_, action) = words.split_once(' ').expect("a time");
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
    fn keys_come_up_when_the_window_gets_the_focus_and_none_goes_down() {
        let seen = Seen::default();
        let log = Arc::clone(&seen.0);
        let (mut device, hush) = Hushed::new(Box::new(seen));
        device.send(&event("key:f", true)).expect("sent");
        hush.store(true, Ordering::Relaxed);
        device.flush().expect("flushed");
        device.send(&event("key:d", true)).expect("held back");
        device.send(&event("pad:a", true)).expect("no key");
        hush.store(false, Ordering::Relaxed);
        device.send(&event("key:f", false)).expect("is up already");
        device.send(&event("key:d", false)).expect("never was down");
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
