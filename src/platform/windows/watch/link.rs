//! gelpad's end of the pipes to a watcher.

use std::cell::RefCell;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::os::windows::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, sync_channel};
use std::time::Duration;

use windows_sys::Win32::System::Threading::{
    CREATE_BREAKAWAY_FROM_JOB, CREATE_NEW_PROCESS_GROUP, DETACHED_PROCESS,
};

use super::ReleaseHandle;
use crate::platform::watch::answers::{AnswerLines, Answers};

/// Longest wait until a watcher is ready.
const READY_WAIT: Duration = Duration::from_secs(5);
/// Longest wait until a watcher ends when nothing is down.
const END_WAIT: Duration = Duration::from_millis(500);
/// Messages of a watcher that wait to be read.
const QUEUE: usize = 64;

/// A running watcher. Dropping the link ends it.
pub(in crate::platform) struct WatcherLink {
    /// Lines to the watcher; none after [`WatcherLink::close`].
    line: RefCell<Option<ChildStdin>>,
    child: Child,
    answers: Receiver<Vec<u8>>,
    received: AnswerLines,
}

impl WatcherLink {
    /// Starts a watcher; `command` is its name among gelpad's commands.
    pub(in crate::platform) fn start(
        program: &Path,
        command: &str,
        _: ReleaseHandle,
    ) -> io::Result<Self> {
        // Without a console, no Ctrl-C and no closed console ends it; outside of gelpad's job, no end of that job.
        let flags = DETACHED_PROCESS | CREATE_NEW_PROCESS_GROUP;
        let spawn = |flags| {
            Command::new(program)
                .args([command, "keys", "--parent"])
                .arg(std::process::id().to_string())
                .stdin(Stdio::piped())
                .stdout(Stdio::piped())
                .stderr(Stdio::null())
                .creation_flags(flags)
                .spawn()
        };
        // Some jobs let nothing out.
        let mut child = spawn(flags | CREATE_BREAKAWAY_FROM_JOB).or_else(|_| spawn(flags))?;
        let (Some(line), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(io::Error::other("it has no pipes"));
        };
        Ok(Self {
            line: RefCell::new(Some(line)),
            child,
            answers: read_all(output)?,
            received: AnswerLines::default(),
        })
    }

    /// Waits until the watcher is ready.
    pub(in crate::platform) fn wait(&mut self) -> io::Result<()> {
        let mut answers = Answers::default();
        while !answers.is_ready {
            match self.answers.recv_timeout(READY_WAIT) {
                Ok(bytes) => self.received.feed(&bytes, &mut answers),
                Err(RecvTimeoutError::Timeout) => return Err(ErrorKind::TimedOut.into()),
                Err(RecvTimeoutError::Disconnected) => return Err(ErrorKind::BrokenPipe.into()),
            }
        }
        Ok(())
    }

    /// A watcher of Windows shares no connection.
    pub(in crate::platform) fn cuts_connection(&self) -> bool {
        false
    }

    /// Sends a line. The pipe has room for more than a watcher may leave unread before it is replaced.
    pub(in crate::platform) fn send(&mut self, line: &str) -> io::Result<()> {
        match self.line.get_mut() {
            Some(pipe) => pipe.write_all(line.as_bytes()),
            None => Err(ErrorKind::BrokenPipe.into()),
        }
    }

    /// Reads what the watcher has sent, without waiting.
    pub(in crate::platform) fn read(&mut self) -> Answers {
        let mut answers = Answers::default();
        loop {
            match self.answers.try_recv() {
                Ok(bytes) => self.received.feed(&bytes, &mut answers),
                Err(TryRecvError::Empty) => return answers,
                Err(TryRecvError::Disconnected) => {
                    answers.has_ended = true;
                    return answers;
                }
            }
        }
    }

    /// Kills a watcher that does not answer: closing the pipe would make it release what is held.
    pub(in crate::platform) fn kill(mut self) {
        // It may have ended already.
        let _ = self.child.kill();
    }

    /// Ends the watcher's work, without waiting until the process has ended.
    pub(in crate::platform) fn close(&self) {
        self.line.replace(None);
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

/// Reads a pipe in a thread of its own, which ends with the pipe: pipes of Windows cannot be polled.
fn read_all(mut output: ChildStdout) -> io::Result<Receiver<Vec<u8>>> {
    let (sender, receiver) = sync_channel(QUEUE);
    let thread = std::thread::Builder::new().name("watcher".to_owned());
    thread.spawn(move || {
        let mut bytes = [0; 256];
        while let Ok(count) = output.read(&mut bytes)
            && count > 0
            && sender.send(bytes[..count].to_vec()).is_ok()
        {}
    })?;
    Ok(receiver)
}
