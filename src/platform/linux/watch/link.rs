//! gelpad's end of the socket to a watcher.

use std::io::{self, ErrorKind, Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use super::ReleaseHandle;
use crate::platform::watch::READY;
use crate::platform::watch::answers::{AnswerLines, Answers};

/// Longest wait until a watcher is ready; it starts in about 10 ms.
const READY_WAIT: Duration = Duration::from_secs(5);
/// Longest wait until a watcher ends when nothing is down.
const END_WAIT: Duration = Duration::from_millis(500);

/// A running watcher. Dropping the link ends it.
pub(in crate::platform) struct WatcherLink {
    line: UnixStream,
    child: Child,
    cuts_connection: bool,
    received: AnswerLines,
}

impl WatcherLink {
    /// Starts a watcher; `command` is its name among gelpad's commands.
    pub(in crate::platform) fn start(
        program: &Path,
        command: &str,
        handle: ReleaseHandle,
    ) -> io::Result<Self> {
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
            received: AnswerLines::default(),
        })
    }

    /// Waits until the watcher is ready.
    pub(in crate::platform) fn wait(&mut self) -> io::Result<()> {
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
    pub(in crate::platform) fn cuts_connection(&self) -> bool {
        self.cuts_connection
    }

    /// Sends a line. A watcher that does not read its lines counts as gone.
    pub(in crate::platform) fn send(&mut self, line: &str) -> io::Result<()> {
        self.line.write_all(line.as_bytes())
    }

    /// Reads what the watcher has sent, without waiting.
    pub(in crate::platform) fn read(&mut self) -> Answers {
        let mut answers = Answers::default();
        let mut bytes = [0; 256];
        loop {
            match self.line.read(&mut bytes) {
                Ok(0) => answers.has_ended = true,
                Ok(count) => {
                    self.received.feed(&bytes[..count], &mut answers);
                    continue;
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(_) => answers.has_ended = true,
            }
            return answers;
        }
    }

    /// Kills a watcher that does not answer: closing the socket would make it release what is held.
    pub(in crate::platform) fn kill(mut self) {
        // It may have ended already.
        let _ = self.child.kill();
    }

    /// Ends the watcher's work, without waiting until the process has ended.
    pub(in crate::platform) fn close(&self) {
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
