//! A pseudo-terminal: the board's end of a serial port that needs no hardware.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// The board's end, and where the host finds the other one.
pub struct Pty {
    board: File,
    path: PathBuf,
    link: Option<PathBuf>,
}

impl Pty {
    /// A new pseudo-terminal; with a link to it at a path, if one is given: that path stays when the port hangs up.
    ///
    /// # Errors
    /// None left; a path that is taken.
    pub fn open(link: Option<&Path>) -> io::Result<Self> {
        // Closed on exec: a child that inherits the board's end would keep the port alive.
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let board = openpt(flags)?;
        grantpt(&board)?;
        unlockpt(&board)?;
        // Raw from the start: what is written before the host opens it must not be echoed or edited.
        let mut modes = tcgetattr(&board)?;
        modes.make_raw();
        tcsetattr(&board, OptionalActions::Now, &modes)?;
        fcntl_setfl(&board, fcntl_getfl(&board)? | OFlags::NONBLOCK)?;
        let name = ptsname(&board, Vec::new())?;
        let path = PathBuf::from(name.to_string_lossy().into_owned());
        // Opened and closed once: only then does the system tell whether someone has it open.
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

    /// What the host opens.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.link.as_deref().unwrap_or(&self.path)
    }

    /// Whether someone has the other end open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        let mut fds = [PollFd::new(&self.board, PollFlags::IN)];
        let polled = poll(&mut fds, Some(&Timespec::default()));
        polled.is_ok() && !fds[0].revents().contains(PollFlags::HUP)
    }

    /// Waits until something came, at most so long.
    pub fn wait(&self, at_most: Duration) {
        let mut fds = [PollFd::new(&self.board, PollFlags::IN)];
        // A signal may end it early: whoever waits looks again.
        let _ = poll(&mut fds, Timespec::try_from(at_most).ok().as_ref());
    }

    /// What came; nothing if nothing did.
    ///
    /// # Errors
    /// The terminal's; not that nobody has it open.
    pub fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.board.read(buffer) {
            Err(error) if is_nothing(&error) => Ok(0),
            other => other,
        }
    }

    /// Sends bytes, or as many as there is room for; none if nobody has it open.
    ///
    /// # Errors
    /// The terminal's.
    pub fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.board.write(bytes) {
            Err(error) if is_nothing(&error) => {
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

fn is_nothing(error: &io::Error) -> bool {
    // EIO: nobody has the other end open.
    error.kind() == io::ErrorKind::WouldBlock
        || error.kind() == io::ErrorKind::Interrupted
        || error.raw_os_error() == Some(rustix::io::Errno::IO.raw_os_error())
}

/// Puts a link in place at once; anything but a link stays.
fn replace_link(link: &Path, path: &Path) -> io::Result<()> {
    if link
        .symlink_metadata()
        .is_ok_and(|there| !there.is_symlink())
    {
        return Err(io::Error::new(
            io::ErrorKind::AlreadyExists,
            format!(
                "{} is there and is no link: choose a free path",
                link.display()
            ),
        ));
    }
    let mut beside = link.as_os_str().to_owned();
    beside.push(format!(".{}", std::process::id()));
    let _ = std::fs::remove_file(&beside);
    std::os::unix::fs::symlink(path, &beside)?;
    std::fs::rename(&beside, link)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_knows_whether_someone_has_it_open_and_keeps_its_path() {
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
        let mut heard = [0; 8];
        assert_eq!(pty.read(&mut heard).expect("read"), 1);
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
