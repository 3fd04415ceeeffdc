//! A watcher process that releases keys when gelpad is killed, stopped or hangs.
//!
//! Displays keep a key down when the client that pressed it is killed (X11) or stopped (X11 and Wayland). Therefore
//! gelpad starts `gelpad watch`, a small process that keeps a list of the outputs that are down. (Devices of the
//! kernel are released by the kernel, they need no watcher.)
//!
//! ```text
//! gelpad ──"press key:f", "beat", "release key:f"──▶ watcher
//!        ◀───────"ready", "released"────────────────
//! ```
//! The two share a socket, which is the watcher's standard input. A message is one line of text:
//!
//! | line | sender | meaning |
//! | --- | --- | --- |
//! | `ready` | watcher | it watches from now on |
//! | `press OUTPUT` | gelpad | the output is about to go down: sent before the press itself |
//! | `release OUTPUT` | gelpad | the output is up: sent after the release itself |
//! | `beat` | gelpad | alive: at least every 200 ms, from the thread that sends events, so that a hanging thread shows |
//! | `released` | watcher | gelpad was silent for 2 s, so everything was released |
//!
//! If the socket closes, gelpad has ended: the watcher releases what is down and ends too. If gelpad continues after
//! `released`, it reconnects if necessary and presses again what is still held.
//!
//! Invariants: the watcher's list contains every output that may be down. The watcher ends only after gelpad has
//! (`process.rs`). It releases only what gelpad's virtual device holds, never a key of a real keyboard.

mod link;
mod process;

use std::os::fd::OwnedFd;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::{HeldOutputs, OutputDevice, OutputError, now};
use crate::types::{Action, Event, Output};
use link::WatcherLink;
pub use process::run_watcher;

/// A parent that is silent for longer counts as stopped, and what it holds is released.
const STOPPED: Duration = Duration::from_secs(2);
/// Time between two beats: a tenth of [`STOPPED`], so that a busy computer is not taken for a stopped process.
const BEAT: Duration = Duration::from_millis(200);
/// After a stop the engine gets this much time to catch up before what is still held is pressed again.
const CATCH_UP: Duration = Duration::from_millis(100);
/// Time until a watcher that could not be started, or has ended, is started again.
const RESTART: Duration = Duration::from_secs(5);

/// How a watcher releases what is down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReleaseMethod {
    /// It sends releases over its own connection to the X11 display that `DISPLAY` names.
    X11 {
        /// A window of the parent's connection: while it exists, a press of the parent may still be on its way.
        window: u32,
    },
    /// It shuts down the parent's connection, which it shares: the compositor then releases what the client held.
    CutConnection,
}

/// What a watcher needs to release the outputs of a device.
#[derive(Debug)]
pub enum ReleaseHandle {
    /// An X11 display, and a window of the connection to it.
    X11 {
        /// Name of the display.
        display: String,
        /// The window.
        window: u32,
    },
    /// The connection to shut down.
    Connection(OwnedFd),
}

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
}

/// A device with its watcher.
pub struct WatchedDevice<D: Watchable> {
    device: D,
    program: PathBuf,
    link: Option<WatcherLink>,
    held: HeldOutputs,
    /// Releases that go out with the next flush; the watcher learns of them after it.
    releasing: HeldOutputs,
    last_message: Instant,
    /// When to start a watcher again.
    restart_at: Option<Instant>,
    /// Whether the missing watcher was logged.
    logged_loss: bool,
    /// When to press again what the watcher has released.
    repress_at: Option<Instant>,
    repress: HeldOutputs,
}

impl<D: Watchable> WatchedDevice<D> {
    /// Starts a watcher; `program` is gelpad's own binary.
    ///
    /// If that fails, a warning is logged and the start is tried again later.
    pub fn new(device: D, program: PathBuf) -> Self {
        let mut watched = Self {
            device,
            program,
            link: None,
            held: HeldOutputs::default(),
            releasing: HeldOutputs::default(),
            last_message: now(),
            restart_at: None,
            logged_loss: false,
            repress_at: None,
            repress: HeldOutputs::default(),
        };
        watched.start();
        let ready = watched.link.as_mut().map_or(Ok(()), WatcherLink::wait);
        if let Err(error) = ready {
            watched.drop_watcher(&error);
        }
        watched
    }

    /// Starts a watcher and sends it what is down, without waiting until it is ready.
    fn start(&mut self) {
        self.restart_at = None;
        let handle = self.device.release_handle();
        match handle.and_then(|handle| WatcherLink::start(&self.program, handle)) {
            Ok(link) => {
                self.link = Some(link);
                for output in self.held.clone().iter() {
                    self.say("press", Some(output));
                }
            }
            Err(error) => self.drop_watcher(&error),
        }
    }

    fn drop_watcher(&mut self, error: &std::io::Error) {
        if !std::mem::replace(&mut self.logged_loss, true) {
            tracing::warn!("no watcher ({error}): a key may stay down if gelpad is killed");
        }
        if let Some(link) = self.link.take() {
            link.kill();
        }
        self.restart_at = Some(now() + RESTART);
    }

    /// Sends a line to the watcher.
    fn say(&mut self, word: &str, output: Option<Output>) {
        let Some(link) = &mut self.link else {
            return;
        };
        let line = match output {
            Some(output) => format!("{word} {output}\n"),
            None => format!("{word}\n"),
        };
        match link.say(&line) {
            Ok(()) => self.last_message = now(),
            Err(error) => self.drop_watcher(&error),
        }
    }

    /// If the watcher has released everything, prepares to press again what is still held.
    fn check_released(&mut self) -> Result<(), OutputError> {
        if !self.link.as_mut().is_some_and(WatcherLink::has_released) {
            return Ok(());
        }
        tracing::warn!(
            "gelpad was stopped for over {} s: its keys were released",
            STOPPED.as_secs()
        );
        if self.link.as_ref().is_some_and(WatcherLink::cuts_connection) {
            self.device.reconnect()?;
            self.link = None;
            self.start();
        }
        self.repress.clone_from(&self.held);
        self.repress_at = Some(now() + CATCH_UP);
        Ok(())
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
        self.check_released()?;
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
        self.check_released()?;
        self.held.record(&event.action);
        match event.action {
            Action::Press(output) => {
                self.repress.release(output);
                self.releasing.release(output);
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
        let result = self.device.flush();
        self.or_retry(result, OutputDevice::flush)?;
        for output in self.releasing.take() {
            self.say("release", Some(output));
        }
        Ok(())
    }

    fn idle(&mut self) -> Result<(), OutputError> {
        self.check_released()?;
        let now = now();
        if self.repress_at.is_some_and(|at| at <= now) {
            self.press_again()?;
        }
        if self.restart_at.is_some_and(|at| at <= now) {
            self.start();
        }
        if now.saturating_duration_since(self.last_message) >= BEAT {
            self.say("beat", None);
        }
        self.device.idle()
    }
}
