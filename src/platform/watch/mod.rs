//! Watcher processes that release keys when gelpad is killed, stopped or hangs.
//!
//! Displays keep a key down when the client that pressed it is killed (X11) or stopped (X11 and Wayland). Therefore
//! gelpad starts two small processes, `gelpad watch` and `gelpad guard`, each of which keeps a list of the outputs that are
//! down. Each is in a session and process group of its own, so that whoever kills gelpad and one of them leaves the other;
//! one that ends or stops answering is replaced. The second asks for a systemd scope of its own (`linux/watch/scope.rs`). (Devices of the kernel are released by the kernel, they need no watcher.)
//!
//! ```text
//! gelpad ──"press key:f", "beat", "release key:f"──▶ watcher
//!        ◀──────"ready", "beat", "released"─────────
//! ```
//! The two share a socket, which is the watcher's standard input. A message is one line of text:
//!
//! | line | sender | meaning |
//! | --- | --- | --- |
//! | `ready` | watcher | it watches from now on |
//! | `press OUTPUT` | gelpad | the output is about to go down: sent before the press itself |
//! | `release OUTPUT` | gelpad | the output is up: sent when the display has confirmed the release |
//! | `beat` | gelpad | alive: at least every 200 ms, from the thread that sends events, so that a hanging thread shows |
//! | `beat` | watcher | the answer to a beat: a watcher that is stopped does not send it |
//! | `released` | watcher | gelpad was silent for 2 s, so everything was released |
//!
//! If the socket closes, gelpad has ended: the watcher releases what is down and ends too. If gelpad continues after
//! `released`, it reconnects if necessary and presses again what is still held.
//!
//! If gelpad and both watchers are killed at the same time, the next gelpad releases what they left (`state.rs`).
//!
//! Invariants: a watcher's list contains every output that may be down; an output leaves it only when the display has
//! confirmed its release. A watcher ends only after gelpad has (`parent_state.rs`). It releases only what gelpad's virtual device
//! holds, never a key of a real keyboard.

pub(super) mod answers;
pub(super) mod parent_state;
mod slot;
pub(super) mod state;

use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::{Duration, Instant};

pub use super::system::watch::ReleaseHandle;
use crate::output::{HeldOutputs, OutputDevice, OutputError, now};
use crate::types::{Action, Event, Output};
use slot::Slot;

/// Names of the watchers among gelpad's commands: different, so that neither is killed by the name of the other.
pub(super) const COMMANDS: [&str; 2] = ["watch", "guard"];
pub(super) const READY: &str = "ready";
pub(super) const RELEASED: &str = "released";
pub(super) const BEAT_LINE: &str = "beat";
/// A parent that is silent for longer counts as stopped, and what it holds is released.
pub(super) const STOPPED: Duration = Duration::from_secs(2);
/// Time between two beats: a tenth of [`STOPPED`], so that a busy computer is not taken for a stopped process.
const BEAT: Duration = Duration::from_millis(200);
/// After a stop the engine gets this much time to catch up before what is still held is pressed again.
const CATCH_UP: Duration = Duration::from_millis(100);

/// A device that needs a watcher.
pub trait Watchable: OutputDevice {
    /// What a watcher needs to release this device's outputs.
    ///
    /// # Errors
    /// The connection cannot be shared.
    fn release_handle(&self) -> std::io::Result<ReleaseHandle>;

    /// Connects again after the watcher has shut down the connection. Nothing is down then.
    ///
    /// # Errors
    /// The display is gone.
    fn reconnect(&mut self) -> Result<(), OutputError>;

    /// Requests, with the next flush, a confirmation that the display has read everything up to here; returns its number.
    /// `None`: none is needed, because the display releases what a connection held when that ends.
    ///
    /// # Errors
    /// The display is gone.
    fn request_confirmation(&mut self) -> Result<Option<u32>, OutputError> {
        Ok(None)
    }

    /// Number of the last confirmation that has arrived.
    fn confirmed(&self) -> u32 {
        0
    }

    /// Waits, for a limited time, until the display has read everything; whether it has.
    fn finish(&mut self) -> bool {
        true
    }
}

/// A device with its watchers.
pub struct WatchedDevice<D: Watchable> {
    device: D,
    program: PathBuf,
    slots: [Slot; COMMANDS.len()],
    held: HeldOutputs,
    /// Releases that go out with the next flush.
    releasing: HeldOutputs,
    /// Releases that the display has not confirmed, with the number of the confirmation; the watchers learn of them then.
    unconfirmed: VecDeque<(u32, Output)>,
    last_message: Instant,
    /// When to press again what a watcher has released.
    repress_at: Option<Instant>,
    repress: HeldOutputs,
}

impl<D: Watchable> WatchedDevice<D> {
    /// Starts the watchers; `program` is gelpad's own binary.
    ///
    /// If that fails, a warning is logged and the start is tried again later.
    pub fn new(device: D, program: PathBuf) -> Self {
        let mut watched = Self {
            device,
            program,
            slots: COMMANDS.map(Slot::new),
            held: HeldOutputs::default(),
            releasing: HeldOutputs::default(),
            unconfirmed: VecDeque::new(),
            last_message: now(),
            repress_at: None,
            repress: HeldOutputs::default(),
        };
        watched.start_all();
        let failed = watched
            .slots
            .iter_mut()
            .filter_map(|slot| slot.wait().err());
        let failed: Vec<_> = failed.collect();
        if let Some(error) = failed.first() {
            let loss = match failed.len() {
                1 => "one of two watchers is missing",
                _ => "there is no watcher",
            };
            tracing::warn!(
                "{loss} ({error}): a key may stay down if gelpad is killed\n  help: close a program if the display has \
                 too many clients, or use --output gamepad, whose devices the kernel releases"
            );
        }
        watched
    }

    fn start_all(&mut self) {
        for index in 0..self.slots.len() {
            self.start(index);
        }
    }

    /// Starts a watcher and sends it what may be down, without waiting until it is ready.
    fn start(&mut self, index: usize) {
        let handle = self.device.release_handle();
        let slot = &mut self.slots[index];
        slot.start(&self.program, handle);
        let unconfirmed = self.unconfirmed.iter().map(|(_, output)| *output);
        for output in self
            .held
            .iter()
            .chain(self.releasing.iter())
            .chain(unconfirmed)
        {
            slot.send(&format!("press {output}\n"));
        }
    }

    /// Sends a line to the watchers.
    fn say(&mut self, word: &str, output: Option<Output>) {
        let line = match output {
            Some(output) => format!("{word} {output}\n"),
            None => format!("{word}\n"),
        };
        self.slots.iter_mut().for_each(|slot| slot.send(&line));
        self.last_message = now();
    }

    /// Reads what the watchers sent. If one has released everything, prepares to press again what is still held.
    fn poll_watchers(&mut self) -> Result<(), OutputError> {
        let released = self.slots.each_mut().map(Slot::poll);
        if !released.contains(&true) {
            return Ok(());
        }
        tracing::warn!(
            "gelpad was stopped for over {} s: its keys were released",
            STOPPED.as_secs()
        );
        if self.slots.iter().any(Slot::cuts_connection) {
            self.device.reconnect()?;
            self.slots.iter_mut().for_each(Slot::discard);
            self.start_all();
        }
        self.repress.clone_from(&self.held);
        self.repress_at = Some(now() + CATCH_UP);
        Ok(())
    }

    /// Tells the watchers which releases the display has confirmed.
    fn report_confirmed(&mut self) {
        let confirmed = self.device.confirmed();
        while let Some((number, output)) = self.unconfirmed.front().copied()
            && number <= confirmed
        {
            self.unconfirmed.pop_front();
            self.say("release", Some(output));
        }
    }

    /// Presses again what is still held of what the watcher has released.
    fn press_again(&mut self) -> Result<(), OutputError> {
        self.repress_at = None;
        for output in self.repress.take() {
            self.say("press", Some(output));
            self.device.send(&Event {
                t_ns: 0,
                action: Action::Press(output),
            })?;
        }
        self.device.flush()
    }

    /// After a failure, tries once more if the cause was that the watcher had just shut down the connection.
    fn or_retry(
        &mut self,
        result: Result<(), OutputError>,
        again: impl FnOnce(&mut D) -> Result<(), OutputError>,
    ) -> Result<(), OutputError> {
        let Err(error) = result else {
            return Ok(());
        };
        self.poll_watchers()?;
        if self.repress_at.is_none() {
            return Err(error);
        }
        again(&mut self.device)
    }
}

impl<D: Watchable> OutputDevice for WatchedDevice<D> {
    fn name(&self) -> &str {
        self.device.name()
    }

    fn supports(&self, output: Output) -> bool {
        self.device.supports(output)
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        self.poll_watchers()?;
        self.held.record(&event.action);
        match event.action {
            Action::Press(output) => {
                self.repress.release(output);
                self.releasing.release(output);
                self.unconfirmed.retain(|(_, one)| *one != output);
                self.say("press", Some(output));
            }
            Action::Release(output) => {
                self.repress.release(output);
                self.releasing.press(output);
            }
            Action::Axis(..) | Action::Motion { .. } | Action::Wheel { .. } => {}
        }
        let result = self.device.send(event);
        self.or_retry(result, |device| device.send(event))
    }

    fn flush(&mut self) -> Result<(), OutputError> {
        let number = match self.releasing.is_empty() {
            true => None,
            false => self.device.request_confirmation()?,
        };
        let result = self.device.flush();
        self.or_retry(result, OutputDevice::flush)?;
        for output in self.releasing.take() {
            match number {
                Some(number) => self.unconfirmed.push_back((number, output)),
                None => self.say("release", Some(output)),
            }
        }
        self.report_confirmed();
        Ok(())
    }

    fn idle(&mut self) -> Result<(), OutputError> {
        self.poll_watchers()?;
        let now = now();
        if self.repress_at.is_some_and(|at| at <= now) {
            self.press_again()?;
        }
        for index in 0..self.slots.len() {
            if self.slots[index].is_due() {
                self.start(index);
            }
        }
        if now.saturating_duration_since(self.last_message) >= BEAT {
            self.say(BEAT_LINE, None);
        }
        self.device.idle()?;
        self.report_confirmed();
        Ok(())
    }
}

impl<D: Watchable> Drop for WatchedDevice<D> {
    /// What the display has not confirmed in time stays on the watchers' lists: they release it.
    fn drop(&mut self) {
        if self.device.finish() {
            for (_, output) in std::mem::take(&mut self.unconfirmed) {
                self.say("release", Some(output));
            }
        }
        self.slots.iter().for_each(Slot::close);
    }
}
