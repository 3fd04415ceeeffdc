//! Windows has no pseudo-terminals for serial ports: a simulated board needs another system, or two ports with a cable.

use std::convert::Infallible;
use std::io;
use std::path::Path;
use std::time::Duration;

/// The board's end of a port: there is none on Windows.
pub struct Pty(Infallible);

impl Pty {
    /// Explains where a simulated board runs.
    ///
    /// # Errors
    /// Always.
    pub fn open(_: Option<&Path>) -> io::Result<Self> {
        Err(io::Error::new(
            io::ErrorKind::Unsupported,
            "Windows has no pseudo-terminals\n  help: run the simulated board on Linux, or play with --source simulated",
        ))
    }

    /// The path that the host opens.
    #[must_use]
    pub fn path(&self) -> &Path {
        match self.0 {}
    }

    /// Whether a host has the other end open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        match self.0 {}
    }

    /// Waits until bytes arrive, but not longer than `at_most`.
    pub fn wait(&self, _: Duration) {
        match self.0 {}
    }

    /// Reads the bytes that have arrived.
    ///
    /// # Errors
    /// None.
    pub fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        match self.0 {}
    }

    /// Sends as many bytes as there is room for.
    ///
    /// # Errors
    /// None.
    pub fn write(&mut self, _: &[u8]) -> io::Result<usize> {
        match self.0 {}
    }
}
