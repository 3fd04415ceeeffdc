//! The watcher itself: `gelpad watch`, started by gelpad and by nobody else.
//!
//! It reads lines on its standard input until that closes, which is when its parent has ended. It is in a session of its own
//! and deaf to the signals that end its parent, so that one Ctrl-C does not end both. Nothing keeps it: what it waits for
//! after its parent's end has a limit.

use std::io::{self, Read as _, Write as _};
use std::net::Shutdown;
use std::os::fd::AsFd as _;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use signal_hook::consts::{SIGALRM, SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGTSTP, SIGUSR1, SIGUSR2};

use super::link::{READY, RELEASED};
use super::{STOPPED, Way, now};
use crate::output::{Device as _, OutputError, X11};
use crate::types::{Action, Event, Output};

/// Signals that are meant for the parent.
const DEAF_TO: [i32; 8] = [
    SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGALRM, SIGUSR1, SIGUSR2,
];
/// A display that does not answer keeps a watcher without a parent for so long at most.
const LAST_WAIT: Duration = Duration::from_secs(10);

/// Watches until standard input closes.
///
/// # Errors
/// The display does not answer.
pub fn watch(way: Way) -> Result<(), OutputError> {
    // It fails where this is a session's first process already: then it has its own.
    let _ = rustix::process::setsid();
    let heard = Arc::new(AtomicBool::new(false));
    for signal in DEAF_TO {
        signal_hook::flag::register(signal, Arc::clone(&heard)).map_err(lost)?;
    }
    let mut hands = Hands::reach(way)?;
    let line = io::stdin().as_fd().try_clone_to_owned().map_err(lost)?;
    let mut line = UnixStream::from(line);
    line.write_all(READY).map_err(lost)?;
    let mut known = Known::default();
    loop {
        match known.hear(&mut line).map_err(lost)? {
            Heard::Lines => {}
            Heard::Silence => {
                hands.let_go(&known.down)?;
                known.down.clear();
                // A parent that is gone by now is noticed next.
                let _ = line.write_all(RELEASED);
            }
            Heard::End => {
                if known.down.is_empty() {
                    return Ok(());
                }
                end_in_time();
                hands.let_go(&known.down)?;
                // A press that the parent sent just before its end may still be on its way.
                hands.wait_for_the_last_event()?;
                return hands.let_go(&known.down);
            }
        }
    }
}

/// What the parent has said.
#[derive(Default)]
struct Known {
    down: Vec<Output>,
    /// The beginning of a line that is not yet whole.
    partial: Vec<u8>,
    heard_at: Option<Instant>,
}

enum Heard {
    Lines,
    Silence,
    End,
}

impl Known {
    /// Waits for something to happen.
    fn hear(&mut self, line: &mut UnixStream) -> io::Result<Heard> {
        let since = now().saturating_duration_since(*self.heard_at.get_or_insert_with(now));
        // What is not down needs no watch.
        let left = (!self.down.is_empty()).then(|| STOPPED.saturating_sub(since));
        let timeout = left.and_then(|left| Timespec::try_from(left).ok());
        let mut waited = [PollFd::new(line, PollFlags::IN)];
        match poll(&mut waited, timeout.as_ref()) {
            Ok(0) => {
                self.heard_at = None;
                return Ok(Heard::Silence);
            }
            Ok(_) => {}
            Err(rustix::io::Errno::INTR) => return Ok(Heard::Lines),
            Err(error) => return Err(error.into()),
        }
        let mut bytes = [0; 4096];
        let count = match line.read(&mut bytes) {
            Ok(0) => return Ok(Heard::End),
            Ok(count) => count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => return Ok(Heard::Lines),
            // A parent that was killed with lines unread may reset the line.
            Err(_) => return Ok(Heard::End),
        };
        self.heard_at = Some(now());
        for byte in &bytes[..count] {
            if *byte == b'\n' {
                let text = String::from_utf8_lossy(&self.partial).into_owned();
                self.partial.clear();
                self.note(&text);
            } else {
                self.partial.push(*byte);
            }
        }
        Ok(Heard::Lines)
    }

    fn note(&mut self, line: &str) {
        let Some((what, output)) = line.split_once(' ') else {
            return;
        };
        let Ok(output) = output.parse::<Output>() else {
            return;
        };
        self.down.retain(|one| *one != output);
        if what == "press" {
            self.down.push(output);
        }
    }
}

/// What lets go.
enum Hands {
    X11 { display: Box<X11>, window: u32 },
    Cut(UnixStream),
}

impl Hands {
    fn reach(way: Way) -> Result<Self, OutputError> {
        match way {
            Way::X11 { window } => {
                let mut display = Box::new(X11::connect()?);
                display.follow(window)?;
                Ok(Self::X11 { display, window })
            }
            Way::Cut => {
                let shared = io::stdout().as_fd().try_clone_to_owned().map_err(lost)?;
                Ok(Self::Cut(UnixStream::from(shared)))
            }
        }
    }

    fn wait_for_the_last_event(&mut self) -> Result<(), OutputError> {
        match self {
            Self::X11 { display, window } => display.wait_for_end_of(*window, LAST_WAIT),
            Self::Cut(_) => Ok(()),
        }
    }

    fn let_go(&mut self, down: &[Output]) -> Result<(), OutputError> {
        match self {
            Self::X11 { display, .. } => {
                for output in down {
                    display.send(&Event {
                        t_ns: 0,
                        action: Action::Release(*output),
                    })?;
                }
                display.sync()
            }
            // One that the compositor has closed is as good as cut.
            Self::Cut(shared) => {
                let _ = shared.shutdown(Shutdown::Both);
                Ok(())
            }
        }
    }
}

/// Ends this process after a while, whatever the display does.
fn end_in_time() {
    let started = std::thread::Builder::new()
        .name("end".to_owned())
        .spawn(|| {
            std::thread::sleep(LAST_WAIT);
            std::process::exit(1);
        });
    if started.is_err() {
        tracing::debug!("no thread to end by");
    }
}

fn lost(error: io::Error) -> OutputError {
    OutputError::Refused {
        device: "watcher's line",
        reason: error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_down_is_what_was_pressed_and_not_released() {
        let (mut parent, mut line) = UnixStream::pair().expect("a line");
        let mut known = Known::default();
        let mut told = |text: &str| {
            parent.write_all(text.as_bytes()).expect("told");
            assert!(matches!(known.hear(&mut line), Ok(Heard::Lines)));
            known.down.iter().map(Output::to_string).collect::<Vec<_>>()
        };
        assert_eq!(
            told("press key:f\npress mouse:left\npre"),
            ["key:f", "mouse:left"]
        );
        assert_eq!(
            told("ss key:d\nbeat\nrelease key:f\n"),
            ["mouse:left", "key:d"]
        );
        assert_eq!(told("press key:d\nnonsense\n"), ["mouse:left", "key:d"]);
        drop(parent);
        assert!(matches!(known.hear(&mut line), Ok(Heard::End)));
    }
}
