//! Keys come up even if this process is killed or stopped: a small watcher process knows what is down, and releases it.
//!
//! ```text
//! gelpad ──press key:f, beat, release key:f──▶ watcher      told before a press goes out, after a release has gone out
//!        ◀─────────ready, released───────────
//! ```
//! For displays, which keep what is down when a client is killed (X11) or stopped (both). The kernel's own devices need none.
//!
//! Invariants: what may be down is known to the watcher. The beats come from the thread that sends events, so that one which
//! hangs counts as stopped. The watcher ends when its parent does, whatever ends that, and by nothing else
//! (`process.rs`). It lets go of what the *virtual* device holds: what the player holds on a real keyboard stays.

mod link;
mod process;

use std::os::fd::OwnedFd;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::{Device, OutputError};
use crate::types::{Action, Event, Output};
use link::Link;
pub use process::watch;

/// Longest silence of a parent that is well; then what it holds is released.
const STOPPED: Duration = Duration::from_secs(2);
/// From one beat to the next: so many must be missed that a busy computer is not taken for a stopped process.
const BEAT: Duration = Duration::from_millis(200);
/// After a stop the engine catches up for so long before what is still held is sent anew.
const CATCH_UP: Duration = Duration::from_millis(100);
/// A watcher that could not be started, or is gone, is started again after this.
const AGAIN: Duration = Duration::from_secs(5);

/// How a watcher lets go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// By releases of its own, over its own connection to the X11 display that `DISPLAY` names.
    X11 {
        /// A window of the parent's connection: while it is there, a press of the parent may still be on its way.
        window: u32,
    },
    /// By cutting its parent's connection, which it shares: the compositor releases what a client held.
    Cut,
}

/// What a watcher is given.
#[derive(Debug)]
pub enum Grip {
    /// An X11 display, and a window of the connection to it.
    X11 {
        /// Its name.
        display: String,
        /// The window.
        window: u32,
    },
    /// The connection to cut.
    Cut(OwnedFd),
}

/// A device whose keys need a watcher.
pub trait Watchable: Device {
    /// What a watcher lets go by.
    ///
    /// # Errors
    /// The connection cannot be shared.
    fn grip(&self) -> std::io::Result<Grip>;

    /// Connects again after the connection was cut. Nothing is down then.
    ///
    /// # Errors
    /// The display is gone.
    fn reconnect(&mut self) -> Result<(), OutputError>;
}

/// A device with its watcher.
pub struct Watched<D: Watchable> {
    device: D,
    program: PathBuf,
    link: Option<Link>,
    down: Vec<Output>,
    /// Releases that are sent with the next flush, and told then.
    releasing: Vec<Output>,
    said_at: Instant,
    /// When to start a watcher again.
    again_at: Option<Instant>,
    /// Whether the player knows that there is no watcher.
    loss_told: bool,
    /// When to send anew what is still held of what the watcher has released.
    anew_at: Option<Instant>,
    anew: Vec<Output>,
}

impl<D: Watchable> Watched<D> {
    /// Starts a watcher: `program` is gelpad's own binary.
    ///
    /// A watcher that does not start is told as a warning, and tried again.
    pub fn new(device: D, program: PathBuf) -> Self {
        let mut watched = Self {
            device,
            program,
            link: None,
            down: Vec::new(),
            releasing: Vec::new(),
            said_at: now(),
            again_at: None,
            loss_told: false,
            anew_at: None,
            anew: Vec::new(),
        };
        watched.start();
        let ready = watched.link.as_mut().map_or(Ok(()), Link::wait);
        if let Err(error) = ready {
            watched.lost(&error);
        }
        watched
    }

    /// Starts a watcher and tells it what is down. It hears that once it is ready: events do not wait.
    fn start(&mut self) {
        self.again_at = None;
        let grip = self.device.grip();
        let started = grip.and_then(|grip| Link::start(&self.program, grip));
        match started {
            Ok(link) => {
                self.link = Some(link);
                for index in 0..self.down.len() {
                    self.say("press", Some(self.down[index]));
                }
            }
            Err(error) => self.lost(&error),
        }
    }

    fn lost(&mut self, error: &std::io::Error) {
        if !std::mem::replace(&mut self.loss_told, true) {
            tracing::warn!("no watcher ({error}): a key may stay down if gelpad is killed");
        }
        if let Some(link) = self.link.take() {
            link.kill();
        }
        self.again_at = Some(now() + AGAIN);
    }

    fn say(&mut self, what: &str, output: Option<Output>) {
        let Some(link) = &mut self.link else {
            return;
        };
        let line = match output {
            Some(output) => format!("{what} {output}\n"),
            None => format!("{what}\n"),
        };
        match link.say(&line) {
            Ok(()) => self.said_at = now(),
            Err(error) => self.lost(&error),
        }
    }

    /// Hears whether the watcher has let go of everything meanwhile.
    fn listen(&mut self) -> Result<(), OutputError> {
        if !self.link.as_mut().is_some_and(Link::has_released) {
            return Ok(());
        }
        tracing::warn!(
            "gelpad was stopped for over {} s: its keys were released",
            STOPPED.as_secs()
        );
        if self.link.as_ref().is_some_and(Link::cuts) {
            self.device.reconnect()?;
            self.link = None;
            self.start();
        }
        self.anew.clone_from(&self.down);
        self.anew_at = Some(now() + CATCH_UP);
        Ok(())
    }

    /// Presses again what is still held, after the watcher had let go of it.
    fn send_anew(&mut self) -> Result<(), OutputError> {
        self.anew_at = None;
        for output in std::mem::take(&mut self.anew) {
            self.say("press", Some(output));
            self.device.send(&Event {
                t_ns: 0,
                action: Action::Press(output),
            })?;
        }
        self.device.flush()
    }

    /// Tries once more where the watcher has cut the connection in this very moment.
    fn or_once_more(
        &mut self,
        outcome: Result<(), OutputError>,
        again: impl FnOnce(&mut D) -> Result<(), OutputError>,
    ) -> Result<(), OutputError> {
        let Err(error) = outcome else {
            return Ok(());
        };
        self.listen()?;
        if self.anew_at.is_none() {
            return Err(error);
        }
        again(&mut self.device)
    }
}

impl<D: Watchable> Device for Watched<D> {
    fn name(&self) -> &str {
        self.device.name()
    }

    fn takes(&self, output: Output) -> bool {
        self.device.takes(output)
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        self.listen()?;
        match event.action {
            Action::Press(output) => {
                self.anew.retain(|one| *one != output);
                self.releasing.retain(|one| *one != output);
                if !self.down.contains(&output) {
                    self.down.push(output);
                }
                self.say("press", Some(output));
            }
            Action::Release(output) => {
                self.anew.retain(|one| *one != output);
                self.down.retain(|one| *one != output);
                self.releasing.push(output);
            }
            Action::Axis(..) | Action::Motion { .. } | Action::Wheel { .. } => {}
        }
        let outcome = self.device.send(event);
        self.or_once_more(outcome, |device| device.send(event))
    }

    fn flush(&mut self) -> Result<(), OutputError> {
        let outcome = self.device.flush();
        self.or_once_more(outcome, Device::flush)?;
        for output in std::mem::take(&mut self.releasing) {
            self.say("release", Some(output));
        }
        Ok(())
    }

    fn idle(&mut self) -> Result<(), OutputError> {
        self.listen()?;
        let now = now();
        if self.anew_at.is_some_and(|at| at <= now) {
            self.send_anew()?;
        }
        if self.again_at.is_some_and(|at| at <= now) {
            self.start();
        }
        if now.saturating_duration_since(self.said_at) >= BEAT {
            self.say("beat", None);
        }
        self.device.idle()
    }
}

#[allow(
    clippy::disallowed_methods,
    reason = "a watcher measures silence by the clock"
)]
fn now() -> Instant {
    Instant::now()
}
