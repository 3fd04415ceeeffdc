//! Child processes that end with the test, however it ends.

#![allow(
    clippy::disallowed_methods,
    reason = "deadlines of a test read the clock"
)]

use std::fmt;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use rustix::process::{Pid, Signal, kill_process};

/// How often a condition is checked.
const POLL: Duration = Duration::from_millis(20);
/// Number of lines of a program's messages that are shown.
const SAID_LINES: usize = 20;

/// A running program. Dropping it kills it with SIGKILL (fceux ignores other signals) and reaps it, after SIGTERM if it has a
/// grace period. Its messages go to the file `NAME.said` in the test's folder.
#[derive(Debug)]
pub struct Process {
    name: &'static str,
    child: Child,
    said: PathBuf,
    grace: Duration,
}

impl Process {
    /// Starts `command` with both outputs to the file of messages.
    pub fn start(name: &'static str, command: &mut Command, folder: &Path) -> Result<Self> {
        Self::spawn(name, command, folder, None)
    }

    /// The same for a program that answers on its standard output, which goes to `answer`.
    pub fn start_answering(
        name: &'static str,
        command: &mut Command,
        folder: &Path,
        answer: &Path,
    ) -> Result<Self> {
        Self::spawn(name, command, folder, Some(create(answer)?))
    }

    fn spawn(
        name: &'static str,
        command: &mut Command,
        folder: &Path,
        answer: Option<File>,
    ) -> Result<Self> {
        let said = folder.join(format!("{name}.said"));
        let file = create(&said)?;
        let stdout = match answer {
            Some(answer) => answer,
            None => file.try_clone().context("cannot share a file")?,
        };
        let child = command
            .stdin(Stdio::null())
            .stdout(stdout)
            .stderr(file)
            .spawn()
            .with_context(|| format!("cannot start {name}"))?;
        Ok(Self {
            name,
            child,
            said,
            grace: Duration::ZERO,
        })
    }

    /// When dropped, sends SIGTERM and waits for this long until the program ends before it is killed.
    pub fn with_grace(mut self, grace: Duration) -> Self {
        self.grace = grace;
        self
    }

    /// Waits until `look` finds something, as long as the program runs.
    pub fn wait_for<T>(
        &mut self,
        what: &str,
        patience: Duration,
        mut look: impl FnMut() -> Result<Option<T>>,
    ) -> Result<T> {
        let deadline = Instant::now() + patience;
        loop {
            if let Some(found) = look()? {
                return Ok(found);
            }
            if let Some(status) = self.child.try_wait()? {
                bail!("{} ended ({status}) before {what}\n{self}", self.name);
            }
            ensure!(
                Instant::now() < deadline,
                "no {what} within {patience:?} of {}\n{self}",
                self.name
            );
            thread::sleep(POLL);
        }
    }

    /// Sends a signal to the program.
    #[allow(dead_code, reason = "the game's test sends none")]
    pub fn signal(&self, signal: Signal) -> Result<()> {
        Ok(kill_process(Pid::from_child(&self.child), signal)?)
    }

    /// Waits until the program ends, and fails unless it was successful.
    pub fn succeed(mut self, patience: Duration) -> Result<()> {
        match self.end_within(patience)? {
            Some(status) if status.success() => Ok(()),
            Some(status) => bail!("{} failed ({status})\n{self}", self.name),
            None => bail!("{} did not end within {patience:?}\n{self}", self.name),
        }
    }

    pub fn end_within(&mut self, patience: Duration) -> Result<Option<ExitStatus>> {
        let deadline = Instant::now() + patience;
        loop {
            let status = self.child.try_wait().context("cannot wait for a program")?;
            if status.is_some() || Instant::now() >= deadline {
                return Ok(status);
            }
            thread::sleep(POLL);
        }
    }
}

impl fmt::Display for Process {
    /// The last lines of the program's messages.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let said = fs::read(&self.said).unwrap_or_default();
        let said = String::from_utf8_lossy(&said);
        let lines: Vec<&str> = said.lines().collect();
        writeln!(f, "--- {}, last lines", self.name)?;
        for line in &lines[lines.len().saturating_sub(SAID_LINES)..] {
            writeln!(f, "{line}")?;
        }
        Ok(())
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // An error here means that the program is gone or out of reach.
        if !self.grace.is_zero() {
            let _ = kill_process(Pid::from_child(&self.child), Signal::TERM);
        }
        let ended = self.end_within(self.grace);
        if !matches!(ended, Ok(Some(_))) {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

fn create(path: &Path) -> Result<File> {
    File::create(path).with_context(|| format!("cannot create {}", path.display()))
}
