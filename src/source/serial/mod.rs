//! A board on a serial port (or a pseudo-terminal).
//!
//! It runs on the source's thread and never waits longer than a twentieth of a second. Frames carry the board's own time
//! where it has one (see `clock`), else that of their arrival, in nanoseconds since the port was first opened.
//!
//! A port that goes away is said once ([`Reading::Gone`]); then it is looked for four times a second, by the board's serial
//! number where the system gives one, and opened again. End of file, `BrokenPipe` and EIO all mean gone, and asking
//! such a port again would spin.

mod intake;
mod listen;
mod port;

pub use listen::{Heard, Listener};

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::time::{Duration, Instant};

use serialport::SerialPort;

use super::wire::Format;
use super::{Pace, Reading, Source, SourceError};
use crate::pad::Pad;
use crate::types::Nanos;
use intake::Intake;
use port::Identity;

/// Speed of most boards.
pub const DEFAULT_BAUD: u32 = 115_200;
/// How often a port that is gone is looked for.
const RETRY: Duration = Duration::from_millis(250);
/// Longest sleep of one reading while a port is gone.
const NAP: Duration = Duration::from_millis(50);

/// A port that is read.
pub struct SerialSource {
    path: String,
    baud: u32,
    identity: Option<Identity>,
    /// None while the board is away.
    device: Option<Box<dyn SerialPort>>,
    intake: Intake,
    readings: VecDeque<Reading>,
    started: Instant,
    /// When the talk began; none before the first reading, which may come long after the opening.
    opened_ns: Option<Nanos>,
    next_try: Instant,
    buffer: Vec<u8>,
}

impl SerialSource {
    /// Opens a port whose board reads a pad and speaks a format.
    ///
    /// # Errors
    /// A port that cannot be opened.
    pub fn open(path: &str, baud: u32, pad: &Pad, format: Format) -> Result<Self, SourceError> {
        let device = port::open(path, baud).map_err(|error| SourceError::Open {
            port: path.to_owned(),
            error,
        })?;
        let now = now();
        Ok(Self {
            path: path.to_owned(),
            baud,
            identity: port::identity(path),
            device: Some(device),
            intake: Intake::new(pad, format),
            readings: VecDeque::new(),
            started: now,
            opened_ns: None,
            next_try: now,
            buffer: vec![0; 4096],
        })
    }

    fn now_ns(&self) -> Nanos {
        Nanos::try_from(self.started.elapsed().as_nanos()).unwrap_or(Nanos::MAX)
    }

    /// Reads what is there and says what must be said.
    fn exchange(&mut self, mut device: Box<dyn SerialPort>) -> Result<(), SourceError> {
        let heard = match device.read(&mut self.buffer) {
            Ok(0) => return self.gone(),
            Ok(count) => count,
            Err(error) => match error.kind() {
                ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted => 0,
                _ => return self.gone(),
            },
        };
        let now_ns = self.now_ns();
        let opened_ns = *self.opened_ns.get_or_insert(now_ns);
        let bytes = &self.buffer[..heard];
        self.intake
            .feed(now_ns, opened_ns, bytes, &mut self.readings)?;
        if let Some(words) = self.intake.say(now_ns, opened_ns)
            && let Err(error) = device.write_all(&words)
            && error.kind() != ErrorKind::TimedOut
        {
            return self.gone();
        }
        self.device = Some(device);
        Ok(())
    }

    fn gone(&mut self) -> Result<(), SourceError> {
        self.readings.push_back(Reading::Gone {
            reason: format!(
                "{}: the board is gone (unplugged or reset): all keys are up until it comes back",
                self.path
            ),
        });
        self.next_try = now() + RETRY;
        Ok(())
    }

    /// Looks for the board, or sleeps a little.
    fn look(&mut self) {
        let left = self.next_try.saturating_duration_since(now());
        if !left.is_zero() {
            std::thread::sleep(left.min(NAP));
            return;
        }
        self.next_try = now() + RETRY;
        let found = port::find(&self.path, self.identity.as_ref())
            .and_then(|path| Some((port::open(&path, self.baud).ok()?, path)));
        if let Some((device, path)) = found {
            tracing::warn!("{path}: the board is back");
            self.path = path;
            self.device = Some(device);
            self.opened_ns = Some(self.now_ns());
            self.intake.reopened();
        }
    }
}

impl Source for SerialSource {
    fn pace(&self) -> Pace {
        Pace::ByDevice
    }

    fn read(&mut self) -> Result<Reading, SourceError> {
        if self.readings.is_empty() {
            match self.device.take() {
                Some(device) => self.exchange(device)?,
                None => self.look(),
            }
        }
        Ok(self.readings.pop_front().unwrap_or(Reading::Idle))
    }
}

impl Drop for SerialSource {
    fn drop(&mut self) {
        // A board that cannot be told any more need not be.
        if let Some(device) = &mut self.device {
            let _ = device.write_all(self.intake.farewell());
        }
    }
}

#[allow(
    clippy::disallowed_methods,
    reason = "a board's frames are stamped on arrival"
)]
fn now() -> Instant {
    Instant::now()
}
