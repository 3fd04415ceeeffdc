//! A pseudo-terminal: the board's end of a serial port without hardware.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// The board's end, and the path that the host opens.
pub struct Pty {
    board: File,
    path: PathBuf,
    link: Option<PathBuf>,
}

impl Pty {
    /// Creates a pseudo-terminal, with a link to it if a path is given: that path stays the same when the
    /// port disappears and comes back.
    ///
    /// # Errors
    /// The system has no pseudo-terminal left, or the path is taken.
    pub fn open(link: Option<&Path>) -> io::Result<Self> {
        // Closed on exec: a child process with the board's end would keep the port alive.
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let board = openpt(flags)?;
        grantpt(&board)?;
        unlockpt(&board)?;
        // Raw mode from the start: nothing that is written before the host opens the port may be echoed or edited.
        let mut modes = tcgetattr(&board)?;
        modes.make_raw();
        tcsetattr(&board, OptionalActions::Now, &modes)?;
        fcntl_setfl(&board, fcntl_getfl(&board)? | OFlags::NONBLOCK)?;
        let name = ptsname(&board, Vec::new())?;
        let path = PathBuf::from(name.to_string_lossy().into_owned());
        // Opened and closed once: only after that does the system report whether the port is open.
        drop(File::options().read(true).open(&path)?);
        if let Some(link) = link {
            replace_link(link, &path)?;
        }
        Ok(Self {
            board: File::from(board),
            path,
            link: link.map(Path::to_owned),
        })
    }

    /// The path that the host opens.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.link.as_deref().unwrap_or(&self.path)
    }

    /// Whether a host has the other end open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        let mut fds = [PollFd::new(&self.board, PollFlags::IN)];
        let polled = poll(&mut fds, Some(&Timespec::default()));
        polled.is_ok() && !fds[0].revents().contains(PollFlags::HUP)
    }

    /// Waits until bytes arrive, but not longer than `at_most`.
    pub fn wait(&self, at_most: Duration) {
        let mut fds = [PollFd::new(&self.board, PollFlags::IN)];
        // A signal may end the wait early: the caller checks again.
        let _ = poll(&mut fds, Timespec::try_from(at_most).ok().as_ref());
    }

    /// Reads the bytes that have arrived; 0 if there are none.
    ///
    /// # Errors
    /// Errors of the terminal, except that no host has it open.
    pub fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.board.read(buffer) {
            Err(error) if is_not_ready(&error) => Ok(0),
            other => other,
        }
    }

    /// Sends as many bytes as there is room for; 0 if no host has it open.
    ///
    /// # Errors
    /// Errors of the terminal.
    pub fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.board.write(bytes) {
            Err(error) if is_not_ready(&error) => {
                let mut fds = [PollFd::new(&self.board, PollFlags::OUT)];
                let _ = poll(
                    &mut fds,
                    Some(&Timespec {
                        tv_sec: 0,
                        tv_nsec: 2_000_000,
                    }),
                );
                Ok(0)
            }
            other => other,
        }
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        if let Some(link) = &self.link
            && std::fs::read_link(link).is_ok_and(|there| there == self.path)
        {
            let _ = std::fs::remove_file(link);
        }
    }
}

fn is_not_ready(error: &io::Error) -> bool {
    // EIO: no host has the other end open.
    error.kind() == io::ErrorKind::WouldBlock
        || error.kind() == io::ErrorKind::Interrupted
        || error.raw_os_error() == Some(rustix::io::Errno::IO.raw_os_error())
}

/// Replaces a link atomically; any other file is kept.
fn replace_link(link: &Path, path: &Path) -> io::Result<()> {
    if link
        .symlink_metadata()
        .is_ok_and(|there| !there.is_symlink())
    {
        return Err(io::Error::new(
            io::ErrorKind::AlreadyExists,
            format!(
                "{} exists and is not a link: choose another path",
                link.display()
            ),
        ));
    }
    let mut temporary = link.as_os_str().to_owned();
    temporary.push(format!(".{}", std::process::id()));
    let _ = std::fs::remove_file(&temporary);
    std::os::unix::fs::symlink(path, &temporary)?;
    std::fs::rename(&temporary, link)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_reports_whether_it_is_open_and_keeps_its_path() {
        let folder = tempfile::tempdir().expect("a folder");
        let link = folder.path().join("port");
        let mut pty = Pty::open(Some(&link)).expect("a pseudo-terminal");
        assert_eq!(pty.path(), link);
        assert!(!pty.is_open());
        assert_eq!(pty.read(&mut [0; 8]).expect("nothing"), 0);
        let mut host = File::options()
            .read(true)
            .write(true)
            .open(&link)
            .expect("opened");
        assert!(pty.is_open());
        host.write_all(b"D").expect("written");
        pty.wait(Duration::from_secs(5));
        let mut received = [0; 8];
        assert_eq!(pty.read(&mut received).expect("read"), 1);
        assert_eq!(pty.write(b"\n\x03\x00").expect("written"), 3);
        let mut got = [0; 3];
        host.read_exact(&mut got).expect("raw");
        assert_eq!(&got, b"\n\x03\x00");
        drop(host);
        assert!(!pty.is_open());
        let again = Pty::open(Some(&link)).expect("the link is replaced");
        drop(pty);
        assert!(link.exists(), "it is another's now");
        drop(again);
        assert!(link.symlink_metadata().is_err());
        std::fs::write(&link, "a file").expect("written");
        assert!(Pty::open(Some(&link)).is_err());
    }
}
