//! The terminal that gelpad runs in: keys of the live view, and whether the terminal still exists.
//!
//! A closed terminal sends SIGHUP only to the session that it controls; everything else sees end of file or EIO, for
//! ever. So the file descriptors that were terminals at the start are polled.

use std::fs::File;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::stdio::{stderr, stdin, stdout};
use rustix::termios::isatty;

pub use crate::platform::terminal_key::{KeyCommand, TerminalLost};

/// The standard streams that were terminals at the start.
pub struct Terminal {
    streams: Vec<BorrowedFd<'static>>,
}

impl Terminal {
    /// The terminal of this process.
    pub fn attached() -> Self {
        let mut streams = vec![stdin(), stdout(), stderr()];
        streams.retain(|stream| isatty(*stream));
        Self { streams }
    }

    /// Whether one of them is closed.
    pub fn is_lost(&self) -> bool {
        let now = Duration::ZERO;
        let mut streams = self.streams.iter();
        streams.any(|stream| wait_for(*stream, PollFlags::empty(), now).is_err())
    }
}

/// Reads keys from the terminal: stdin, or `/dev/tty` if stdin is something else.
pub struct Keyboard {
    tty: Option<OwnedFd>,
    is_stdin: bool,
}

impl Keyboard {
    /// Opens it.
    pub fn open() -> Self {
        let is_stdin = isatty(stdin());
        Self {
            tty: File::open("/dev/tty").ok().map(OwnedFd::from),
            is_stdin,
        }
    }

    /// Waits for keys, at most `wait`.
    pub fn read(&mut self, wait: Duration) -> Result<Vec<KeyCommand>, TerminalLost> {
        let file = match &self.tty {
            _ if self.is_stdin => stdin(),
            Some(tty) => tty.as_fd(),
            None => {
                std::thread::sleep(wait);
                return Ok(Vec::new());
            }
        };
        if !wait_for(file, PollFlags::IN, wait)? {
            return Ok(Vec::new());
        }
        let mut bytes = [0; 64];
        match rustix::io::read(file, &mut bytes) {
            Ok(count) if count > 0 => Ok(commands(&bytes[..count])),
            Err(Errno::INTR | Errno::AGAIN) => Ok(Vec::new()),
            Ok(_) | Err(_) => Err(TerminalLost),
        }
    }
}

/// Waits until a stream takes bytes, at most `wait`; returns whether it does. One that is closed does: writing to it
/// fails at once.
pub fn can_write(stream: &impl AsFd, wait: Duration) -> bool {
    wait_for(stream.as_fd(), PollFlags::OUT, wait).unwrap_or(true)
}

/// Waits for a terminal, at most `wait`; returns whether `wanted` is possible.
fn wait_for(file: BorrowedFd<'_>, wanted: PollFlags, wait: Duration) -> Result<bool, TerminalLost> {
    let mut polled = [PollFd::from_borrowed_fd(file, wanted)];
    let timeout = Timespec {
        tv_sec: wait.as_secs() as i64,
        tv_nsec: wait.subsec_nanos().into(),
    };
    // An interrupted call has found nothing yet.
    let _ = poll(&mut polled, Some(&timeout));
    let found = polled[0].revents();
    if found.intersects(PollFlags::HUP | PollFlags::ERR) {
        return Err(TerminalLost);
    }
    Ok(found.intersects(wanted))
}

/// The commands in what one read of a raw terminal returned. Escape sequences, as of arrow keys, are not commands.
fn commands(bytes: &[u8]) -> Vec<KeyCommand> {
    const ESCAPE: u8 = 0x1b;
    if bytes.first() == Some(&ESCAPE) && bytes.len() > 1 {
        return Vec::new();
    }
    let command = |byte: &u8| match byte {
        b'q' | &ESCAPE => Some(KeyCommand::Quit),
        0x03 => Some(KeyCommand::Interrupt),
        b'p' => Some(KeyCommand::Pause),
        b'z' => Some(KeyCommand::Rezero),
        _ => None,
    };
    bytes.iter().filter_map(command).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrow_keys_do_not_quit() {
        assert_eq!(commands(b"\x1b"), [KeyCommand::Quit]);
        assert_eq!(commands(b"\x1b[A"), []);
        assert_eq!(
            commands(b"pz\x03"),
            [KeyCommand::Pause, KeyCommand::Rezero, KeyCommand::Interrupt]
        );
    }
}
