//! gelpad's end of the socket to its watcher.

use std::io::{self, Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use super::ReleaseHandle;

/// Longest wait until a watcher is ready; it starts in about 10 ms.
const READY_WAIT: Duration = Duration::from_secs(5);
/// Longest wait until a watcher ends when nothing is down.
const END_WAIT: Duration = Duration::from_millis(500);

pub(super) const READY: &[u8] = b"ready\n";
pub(super) const RELEASED: &[u8] = b"released\n";

/// A running watcher. Dropping the link ends it.
pub(super) struct WatcherLink {
    line: UnixStream,
    child: Child,
    cuts_connection: bool,
}

impl WatcherLink {
    /// Starts a watcher.
    pub(super) fn start(program: &Path, handle: ReleaseHandle) -> io::Result<Self> {
        let (line, child_end) = UnixStream::pair()?;
        let cuts_connection = matches!(handle, ReleaseHandle::Connection(_));
        let mut command = Command::new(program);
        command
            .arg0("gelpad")
            .arg("watch")
            .stdin(OwnedFd::from(child_end));
        match handle {
            ReleaseHandle::X11 { display, window } => command
                .args(["x11", "--window", &window.to_string()])
                .env("DISPLAY", display)
                .stdout(Stdio::null()),
            ReleaseHandle::Connection(shared) => command.arg("cut").stdout(shared),
        };
        let child = command.stderr(Stdio::null()).spawn()?;
        // The child has its end by now; a copy here would keep the socket open after the child's end.
        drop(command);
        let link = Self {
            line,
            child,
            cuts_connection,
        };
        link.line.set_nonblocking(true)?;
        Ok(link)
    }

    /// Waits until the watcher is ready.
    pub(super) fn wait(&mut self) -> io::Result<()> {
        self.line.set_nonblocking(false)?;
        self.line.set_read_timeout(Some(READY_WAIT))?;
        let mut bytes = [0; READY.len()];
        self.line.read_exact(&mut bytes)?;
        if bytes != READY {
            return Err(io::Error::other("it sent something else than `ready`"));
        }
        self.line.set_nonblocking(true)
    }

    /// Whether the watcher releases by shutting down the connection.
    pub(super) fn cuts_connection(&self) -> bool {
        self.cuts_connection
    }

    /// Sends a line. A watcher that does not read its lines counts as gone.
    pub(super) fn say(&mut self, line: &str) -> io::Result<()> {
        self.line.write_all(line.as_bytes())
    }

    /// Kills a watcher that does not read its lines: closing the socket would make it release what is held.
    pub(super) fn kill(mut self) {
        // It may have ended already.
        let _ = self.child.kill();
    }

    /// Whether the watcher has released everything since the last call.
    pub(super) fn has_released(&mut self) -> bool {
        let mut bytes = [0; 4 * RELEASED.len()];
        let count = self.line.read(&mut bytes).unwrap_or(0);
        bytes[..count]
            .windows(RELEASED.len())
            .any(|line| line == RELEASED)
    }
}

impl Drop for WatcherLink {
    fn drop(&mut self) {
        // It may be gone already.
        let _ = self.line.shutdown(std::net::Shutdown::Both);
        let step = Duration::from_millis(5);
        let mut waited = Duration::ZERO;
        while waited < END_WAIT && matches!(self.child.try_wait(), Ok(None)) {
            std::thread::sleep(step);
            waited += step;
        }
    }
}
