//! gelpad's end of the socket to a watcher.

use std::io::{self, ErrorKind, Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use super::{BEAT_LINE, READY, RELEASED, ReleaseHandle};

/// Longest wait until a watcher is ready; it starts in about 10 ms.
const READY_WAIT: Duration = Duration::from_secs(5);
/// Longest wait until a watcher ends when nothing is down.
const END_WAIT: Duration = Duration::from_millis(500);

/// What a watcher has sent since the last call.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Answers {
    /// It watches.
    pub is_ready: bool,
    /// It has answered a beat.
    pub has_answered: bool,
    /// It has released everything.
    pub has_released: bool,
    /// It has ended.
    pub has_ended: bool,
}

/// A running watcher. Dropping the link ends it.
pub(super) struct WatcherLink {
    line: UnixStream,
    child: Child,
    cuts_connection: bool,
    /// The beginning of an incomplete line.
    partial: Vec<u8>,
}

impl WatcherLink {
    /// Starts a watcher; `command` is its name among gelpad's commands.
    pub(super) fn start(program: &Path, command: &str, handle: ReleaseHandle) -> io::Result<Self> {
        let (line, child_end) = UnixStream::pair()?;
        let cuts_connection = matches!(handle, ReleaseHandle::Connection(_));
        let mut process = Command::new(program);
        process
            .arg0("gelpad")
            .arg(command)
            .stdin(OwnedFd::from(child_end));
        match handle {
            ReleaseHandle::X11 { display, window } => process
                .args(["x11", "--window", &window.to_string()])
                .env("DISPLAY", display)
                .stdout(Stdio::null()),
            ReleaseHandle::Connection(shared) => process.arg("cut").stdout(shared),
        };
        let child = process.stderr(Stdio::null()).spawn()?;
        // The child has its end by now; a copy here would keep the socket open after the child's end.
        drop(process);
        line.set_nonblocking(true)?;
        Ok(Self {
            line,
            child,
            cuts_connection,
            partial: Vec::new(),
        })
    }

    /// Waits until the watcher is ready.
    pub(super) fn wait(&mut self) -> io::Result<()> {
        self.line.set_nonblocking(false)?;
        self.line.set_read_timeout(Some(READY_WAIT))?;
        let mut bytes = vec![0; READY.len() + 1];
        self.line.read_exact(&mut bytes)?;
        if bytes != format!("{READY}\n").into_bytes() {
            return Err(io::Error::other("it sent something else than `ready`"));
        }
        self.line.set_nonblocking(true)
    }

    /// Whether the watcher releases by shutting down the connection.
    pub(super) fn cuts_connection(&self) -> bool {
        self.cuts_connection
    }

    /// Sends a line. A watcher that does not read its lines counts as gone.
    pub(super) fn send(&mut self, line: &str) -> io::Result<()> {
        self.line.write_all(line.as_bytes())
    }

    /// Reads what the watcher has sent, without waiting.
    pub(super) fn read(&mut self) -> Answers {
        let mut answers = Answers::default();
        let mut bytes = [0; 256];
        loop {
            match self.line.read(&mut bytes) {
                Ok(0) => answers.has_ended = true,
                Ok(count) => {
                    self.take_bytes(&bytes[..count], &mut answers);
                    continue;
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(_) => answers.has_ended = true,
            }
            return answers;
        }
    }

    fn take_bytes(&mut self, bytes: &[u8], answers: &mut Answers) {
        for byte in bytes {
            if *byte != b'\n' {
                self.partial.push(*byte);
                continue;
            }
            match self.partial.as_slice() {
                line if line == READY.as_bytes() => answers.is_ready = true,
                line if line == RELEASED.as_bytes() => answers.has_released = true,
                line if line == BEAT_LINE.as_bytes() => answers.has_answered = true,
                _ => {}
            }
            self.partial.clear();
        }
    }

    /// Kills a watcher that does not answer: closing the socket would make it release what is held.
    pub(super) fn kill(mut self) {
        // It may have ended already.
        let _ = self.child.kill();
    }

    /// Ends the watcher's work, without waiting until the process has ended.
    pub(super) fn close(&self) {
        // It may be gone already.
        let _ = self.line.shutdown(std::net::Shutdown::Both);
    }
}

impl Drop for WatcherLink {
    fn drop(&mut self) {
        self.close();
        let step = Duration::from_millis(5);
        let mut waited = Duration::ZERO;
        while waited < END_WAIT && matches!(self.child.try_wait(), Ok(None)) {
            std::thread::sleep(step);
            waited += step;
        }
    }
}
