//! The parent's end of the line to its watcher.

use std::io::{self, Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use super::Grip;

/// Longest wait for a watcher to be ready: it starts in some 10 ms.
const PATIENCE: Duration = Duration::from_secs(5);
/// Longest wait for a watcher to end when nothing is down any more.
const FAREWELL: Duration = Duration::from_millis(500);

pub(super) const READY: &[u8] = b"ready\n";
pub(super) const RELEASED: &[u8] = b"released\n";

/// A watcher that runs. Dropping it ends it.
pub(super) struct Link {
    line: UnixStream,
    child: Child,
    cuts: bool,
}

impl Link {
    /// Starts a watcher.
    pub(super) fn start(program: &Path, grip: Grip) -> io::Result<Self> {
        let (line, theirs) = UnixStream::pair()?;
        let cuts = matches!(grip, Grip::Cut(_));
        let mut command = Command::new(program);
        command
            .arg0("gelpad")
            .arg("watch")
            .stdin(OwnedFd::from(theirs));
        match grip {
            Grip::X11 { display, window } => command
                .args(["x11", "--window", &window.to_string()])
                .env("DISPLAY", display)
                .stdout(Stdio::null()),
            Grip::Cut(shared) => command.arg("cut").stdout(shared),
        };
        let child = command.stderr(Stdio::null()).spawn()?;
        // The child has its end now; ours would keep the line open when it is gone.
        drop(command);
        let link = Self { line, child, cuts };
        link.line.set_nonblocking(true)?;
        Ok(link)
    }

    /// Waits until it is ready.
    pub(super) fn wait(&mut self) -> io::Result<()> {
        self.line.set_nonblocking(false)?;
        self.line.set_read_timeout(Some(PATIENCE))?;
        let mut said = [0; READY.len()];
        self.line.read_exact(&mut said)?;
        if said != READY {
            return Err(io::Error::other("the watcher did not get ready"));
        }
        self.line.set_nonblocking(true)
    }

    /// Whether it lets go by cutting the connection.
    pub(super) fn cuts(&self) -> bool {
        self.cuts
    }

    /// Tells the watcher a line. One that does not read its lines is as good as gone.
    pub(super) fn say(&mut self, line: &str) -> io::Result<()> {
        self.line.write_all(line.as_bytes())
    }

    /// Ends one that does not read its lines: it would take the end of the line for its parent's, and release what is held.
    pub(super) fn kill(mut self) {
        // It may be gone already.
        let _ = self.child.kill();
    }

    /// Whether it has let go of everything since it was last asked.
    pub(super) fn has_released(&mut self) -> bool {
        let mut said = [0; 4 * RELEASED.len()];
        let count = self.line.read(&mut said).unwrap_or(0);
        said[..count]
            .windows(RELEASED.len())
            .any(|line| line == RELEASED)
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        // It may be gone already.
        let _ = self.line.shutdown(std::net::Shutdown::Both);
        let step = Duration::from_millis(5);
        let mut waited = Duration::ZERO;
        while waited < FAREWELL && matches!(self.child.try_wait(), Ok(None)) {
            std::thread::sleep(step);
            waited += step;
        }
    }
}
