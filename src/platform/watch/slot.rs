//! The place of one watcher: it is started again as soon as it has ended or does not answer.

use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

use super::BEAT_LINE;
use super::answers::Answers;
use crate::output::now;
use crate::platform::system::watch::{ReleaseHandle, WatcherLink};

/// A watcher that leaves a beat unanswered for this long is replaced: it was stopped, or hangs.
const ANSWER_LIMIT: Duration = Duration::from_secs(1);
/// A new watcher may take this long until it answers: the display may be busy.
const START_LIMIT: Duration = Duration::from_secs(30);
/// Delay of the second attempt in a row to start a watcher; each further one waits twice as long.
const FIRST_DELAY: Duration = Duration::from_millis(100);
/// Longest delay.
const LAST_DELAY: Duration = Duration::from_secs(5);

/// The place of one watcher.
pub(super) struct Slot {
    command: &'static str,
    link: Option<WatcherLink>,
    is_ready: bool,
    /// When the oldest unanswered beat was sent, or the watcher started.
    unanswered: Option<Instant>,
    /// Attempts since a watcher was last ready.
    attempts: u32,
    restart_at: Option<Instant>,
}

impl Slot {
    /// An empty place; `command` is the watcher's name among gelpad's commands.
    pub(super) fn new(command: &'static str) -> Self {
        Self {
            command,
            link: None,
            is_ready: false,
            unanswered: None,
            attempts: 0,
            restart_at: None,
        }
    }

    /// Starts a watcher without waiting until it is ready.
    pub(super) fn start(&mut self, program: &Path, handle: io::Result<ReleaseHandle>) {
        self.restart_at = None;
        self.is_ready = false;
        self.attempts += 1;
        match handle.and_then(|handle| WatcherLink::start(program, self.command, handle)) {
            Ok(link) => {
                self.link = Some(link);
                self.unanswered = Some(now());
            }
            Err(error) => self.lose(&error),
        }
    }

    /// Waits until a watcher that was just started is ready.
    pub(super) fn wait(&mut self) -> io::Result<()> {
        let Some(link) = &mut self.link else {
            return Err(io::Error::other("it cannot be started"));
        };
        match link.wait() {
            Ok(()) => {
                self.become_ready();
                Ok(())
            }
            Err(error) => {
                self.lose(&error);
                Err(error)
            }
        }
    }

    /// Whether a watcher must be started.
    pub(super) fn is_due(&self) -> bool {
        self.restart_at.is_some_and(|at| at <= now())
    }

    /// Whether its watcher releases by shutting down the connection.
    pub(super) fn cuts_connection(&self) -> bool {
        self.link.as_ref().is_some_and(WatcherLink::cuts_connection)
    }

    /// Sends a line.
    pub(super) fn send(&mut self, line: &str) {
        let Some(link) = &mut self.link else {
            return;
        };
        match link.send(line) {
            Ok(()) if line.trim_end() == BEAT_LINE => {
                self.unanswered.get_or_insert_with(now);
            }
            Ok(()) => {}
            Err(error) => self.lose(&error),
        }
    }

    /// Reads the watcher's answers; whether it has released everything.
    pub(super) fn poll(&mut self) -> bool {
        let Some(link) = &mut self.link else {
            return false;
        };
        let Answers {
            is_ready,
            has_answered,
            has_released,
            has_ended,
        } = link.read();
        if is_ready {
            self.become_ready();
        }
        if has_answered {
            self.unanswered = None;
        }
        let limit = match self.is_ready {
            true => ANSWER_LIMIT,
            false => START_LIMIT,
        };
        if has_ended {
            self.lose(&io::Error::other("it has ended"));
        } else if self.unanswered.is_some_and(|at| at.elapsed() > limit) {
            self.lose(&io::Error::other("it does not answer"));
        }
        has_released
    }

    fn become_ready(&mut self) {
        self.is_ready = true;
        self.unanswered = None;
        self.attempts = 0;
    }

    /// Gives the watcher up; the next one starts at once, or later if none was ready since the last attempt.
    fn lose(&mut self, error: &io::Error) {
        tracing::debug!("the watcher `{}` is lost: {error}", self.command);
        if let Some(link) = self.link.take() {
            link.kill();
        }
        self.is_ready = false;
        self.unanswered = None;
        let delay = match self.attempts {
            0 => Duration::ZERO,
            attempts => FIRST_DELAY * 2u32.saturating_pow(attempts.min(8) - 1),
        };
        self.restart_at = Some(now() + delay.min(LAST_DELAY));
    }

    /// Replaces a watcher whose connection is gone.
    pub(super) fn discard(&mut self) {
        self.link = None;
        self.is_ready = false;
        self.attempts = 0;
    }

    /// Ends the watcher's work, without waiting until the process has ended.
    pub(super) fn close(&self) {
        self.link.iter().for_each(WatcherLink::close);
    }
}
