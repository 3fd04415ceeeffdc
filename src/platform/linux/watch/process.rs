//! A watcher process: `gelpad watch` or `gelpad guard`, started by gelpad only. The protocol is described in `mod.rs`.
//!
//! It reads lines from its standard input until that closes, which means that the parent has ended. It runs
//! in a session of its own and ignores the signals that end its parent, so that one Ctrl-C does not end both.
//! A display that does not answer may still hold keys, so the watcher outlives its parent by up to an hour until it does.

use std::io::{self, Read as _, Write as _};
use std::net::Shutdown;
use std::os::fd::AsFd as _;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use signal_hook::consts::{
    SIGALRM, SIGHUP, SIGINT, SIGPROF, SIGQUIT, SIGTERM, SIGTSTP, SIGTTIN, SIGTTOU, SIGUSR1,
    SIGUSR2, SIGVTALRM, SIGXCPU,
};

use super::scope;
use crate::output::{HeldOutputs, OutputDevice as _, OutputError, now};
use crate::platform::ReleaseMethod;
use crate::platform::linux::x11::X11;
use crate::platform::watch::parent_state::ParentState;
use crate::platform::watch::state::{self, StateFile};
use crate::platform::watch::{BEAT_LINE, READY, RELEASED, STOPPED};
use crate::types::{Action, Event};

/// Signals that are meant for the parent and ignored here.
const IGNORED_SIGNALS: [i32; 13] = [
    SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGTTIN, SIGTTOU, SIGALRM, SIGVTALRM, SIGPROF,
    SIGXCPU, SIGUSR1, SIGUSR2,
];
/// Longest life after the parent's end, in case the display does not answer.
const LAST_WAIT: Duration = Duration::from_secs(3600);
/// After the parent's end, a press that was on its way arrives within this time of a display that answers.
const LAST_PRESS_WAIT: Duration = Duration::from_secs(10);

/// Watches until standard input closes.
///
/// # Errors
/// The display does not answer.
pub fn run_watcher(way: ReleaseMethod) -> Result<(), OutputError> {
    // This fails if the process leads a session already, which is just as well.
    let _ = rustix::process::setsid();
    let received = Arc::new(AtomicBool::new(false));
    for signal in IGNORED_SIGNALS {
        signal_hook::flag::register(signal, Arc::clone(&received)).map_err(socket_error)?;
    }
    let parent = rustix::process::getppid().map_or(0, |pid| pid.as_raw_nonzero().get());
    let mut releaser = Releaser::connect(way, parent)?;
    releaser.release_left_down(false)?;
    let line = io::stdin()
        .as_fd()
        .try_clone_to_owned()
        .map_err(socket_error)?;
    let mut line = UnixStream::from(line);
    line.write_all(format!("{READY}\n").as_bytes())
        .map_err(socket_error)?;
    scope::request();
    let mut watched = Parent::default();
    loop {
        match watched.read_lines(&mut line).map_err(socket_error)? {
            Received::Lines { beats } => {
                releaser.record(&watched.state.held, false);
                // If the parent has ended, the next read shows it.
                let _ = line.write_all(format!("{BEAT_LINE}\n").repeat(beats).as_bytes());
            }
            Received::Silence => {
                releaser.release(&watched.state.held)?;
                let _ = line.write_all(format!("{RELEASED}\n").as_bytes());
            }
            Received::ParentEnded => {
                exit_after_last_wait();
                if !watched.state.held.is_empty() {
                    releaser.record(&watched.state.held, true);
                    releaser.release(&watched.state.held)?;
                    // A press that the parent sent just before its end may still be on its way.
                    releaser.wait_for_last_event()?;
                    releaser.release(&watched.state.held)?;
                }
                return releaser.release_left_down(true);
            }
        }
    }
}

/// The socket to the parent, and what the parent has reported.
#[derive(Default)]
struct Parent {
    state: ParentState,
    last_read: Option<Instant>,
    /// Whether the parent is silent and everything was released.
    is_silent: bool,
}

enum Received {
    Lines {
        /// Beats to be answered.
        beats: usize,
    },
    Silence,
    ParentEnded,
}

impl Parent {
    /// Waits for lines, silence or the end of the parent.
    fn read_lines(&mut self, line: &mut UnixStream) -> io::Result<Received> {
        let since = now().saturating_duration_since(*self.last_read.get_or_insert_with(now));
        // While nothing is down, silence does not matter.
        let matters = !self.state.held.is_empty() && !self.is_silent;
        let left = matters.then(|| STOPPED.saturating_sub(since));
        let timeout = left.and_then(|left| Timespec::try_from(left).ok());
        let mut waited = [PollFd::new(line, PollFlags::IN)];
        match poll(&mut waited, timeout.as_ref()) {
            Ok(0) => {
                self.is_silent = true;
                return Ok(Received::Silence);
            }
            Ok(_) => {}
            Err(rustix::io::Errno::INTR) => return Ok(Received::Lines { beats: 0 }),
            Err(error) => return Err(error.into()),
        }
        let mut bytes = [0; 4096];
        let count = match line.read(&mut bytes) {
            Ok(0) => return Ok(Received::ParentEnded),
            Ok(count) => count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {
                return Ok(Received::Lines { beats: 0 });
            }
            // If the parent was killed with lines unread, the socket may be reset.
            Err(_) => return Ok(Received::ParentEnded),
        };
        self.last_read = Some(now());
        self.is_silent = false;
        let beats = self.state.feed(&bytes[..count]);
        Ok(Received::Lines { beats })
    }
}

/// Releases what is down.
enum Releaser {
    X11 {
        display: Box<X11>,
        window: u32,
        state: Option<StateFile>,
    },
    Cut(UnixStream),
}

impl Releaser {
    fn connect(way: ReleaseMethod, parent: i32) -> Result<Self, OutputError> {
        match way {
            ReleaseMethod::X11 { window } => {
                let mut display = Box::new(X11::connect()?);
                display.follow(window)?;
                let state = state::folder()
                    .and_then(|folder| StateFile::create(&folder, display.display(), parent).ok());
                Ok(Self::X11 {
                    display,
                    window,
                    state,
                })
            }
            ReleaseMethod::Keys { .. } => Err(OutputError::NoDevice {
                device: "watcher",
                reason: "releases without a display are for Windows".to_owned(),
            }),
            ReleaseMethod::CutConnection => {
                let shared = io::stdout()
                    .as_fd()
                    .try_clone_to_owned()
                    .map_err(socket_error)?;
                Ok(Self::Cut(UnixStream::from(shared)))
            }
        }
    }

    /// Releases what killed gelpads have left down.
    fn release_left_down(&mut self, parent_has_ended: bool) -> Result<(), OutputError> {
        let Self::X11 {
            display,
            state: Some(state),
            ..
        } = self
        else {
            return Ok(());
        };
        for (path, held) in state.left_down(parent_has_ended) {
            release_on(display, &held)?;
            state::remove(&path);
        }
        Ok(())
    }

    /// Records what is down on disk.
    fn record(&mut self, held: &HeldOutputs, has_ended: bool) {
        if let Self::X11 {
            state: Some(state), ..
        } = self
        {
            state.set(held, has_ended);
        }
    }

    fn wait_for_last_event(&mut self) -> Result<(), OutputError> {
        match self {
            Self::X11 {
                display, window, ..
            } => display.wait_for_end_of(*window, LAST_PRESS_WAIT).map(drop),
            Self::Cut(_) => Ok(()),
        }
    }

    fn release(&mut self, held: &HeldOutputs) -> Result<(), OutputError> {
        match self {
            Self::X11 { display, state, .. } => {
                let mut held = held.clone();
                if let Some(state) = state {
                    let others = state.held_by_others();
                    others.iter().for_each(|output| held.release(output));
                }
                release_on(display, &held)
            }
            // If the compositor has closed the connection already, nothing is left to do.
            Self::Cut(shared) => {
                let _ = shared.shutdown(Shutdown::Both);
                Ok(())
            }
        }
    }
}

fn release_on(display: &mut X11, held: &HeldOutputs) -> Result<(), OutputError> {
    for output in held.iter() {
        display.send(&Event {
            t_ns: 0,
            action: Action::Release(output),
        })?;
    }
    display.sync()
}

/// Ends this process after [`LAST_WAIT`], even if the display does not answer.
fn exit_after_last_wait() {
    let started = std::thread::Builder::new()
        .name("end".to_owned())
        .spawn(|| {
            std::thread::sleep(LAST_WAIT);
            std::process::exit(1);
        });
    if started.is_err() {
        tracing::debug!("cannot start the thread that limits the wait");
    }
}

fn socket_error(error: io::Error) -> OutputError {
    OutputError::Refused {
        device: "watcher's socket",
        reason: error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn held_is_what_was_pressed_and_not_released() {
        let (mut parent, mut line) = UnixStream::pair().expect("a line");
        let mut parent_state = Parent::default();
        let mut held_after = |text: &str| {
            parent.write_all(text.as_bytes()).expect("sent");
            assert!(matches!(
                parent_state.read_lines(&mut line),
                Ok(Received::Lines { .. })
            ));
            parent_state
                .state
                .held
                .iter()
                .map(|output| output.to_string())
                .collect::<Vec<_>>()
        };
        assert_eq!(
            held_after("press key:f\npress mouse:left\npre"),
            ["key:f", "mouse:left"]
        );
        assert_eq!(
            held_after("ss key:d\nbeat\nrelease key:f\n"),
            ["mouse:left", "key:d"]
        );
        assert_eq!(
            held_after("press key:d\nnonsense\n"),
            ["mouse:left", "key:d"]
        );
        drop(parent);
        assert!(matches!(
            parent_state.read_lines(&mut line),
            Ok(Received::ParentEnded)
        ));
    }
}
