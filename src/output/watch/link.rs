//! The parent's end of the line to its watcher.

use std::io::{self, Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use super::Way;

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
    way: Way,
}

impl Link {
    /// Starts a watcher and waits until it is ready.
    pub(super) fn start(program: &Path, way: Way, shared: Option<OwnedFd>) -> io::Result<Self> {
        let (line, theirs) = UnixStream::pair()?;
        let child = Command::new(program)
            .arg("watch")
            .arg(match way {
                Way::X11 => "x11",
                Way::Cut => "cut",
            })
            .stdin(OwnedFd::from(theirs))
            .stdout(shared.map_or_else(Stdio::null, Stdio::from))
            .stderr(Stdio::null())
            .spawn()?;
        let mut link = Self { line, child, way };
        link.line.set_read_timeout(Some(PATIENCE))?;
        let mut said = [0; READY.len()];
        link.line.read_exact(&mut said)?;
        if said != READY {
            return Err(io::Error::other("the watcher did not get ready"));
        }
        link.line.set_nonblocking(true)?;
        Ok(link)
    }

    pub(super) fn way(&self) -> Way {
        self.way
    }

    /// Tells the watcher a line. One that does not read its lines is as good as gone.
    pub(super) fn say(&mut self, line: &str) -> io::Result<()> {
        self.line.write_all(line.as_bytes())
    }

    /// Whether it has let go of everything since it was last asked.
    pub(super) fn has_released(&mut self) -> bool {
        let mut said = [0; 4 * RELEASED.len()];
        matches!(self.line.read(&mut said), Ok(count) if count > 0)
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
