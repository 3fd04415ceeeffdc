//! A board on a serial port (or a pseudo-terminal).
//!
//! It runs on the source's thread and never waits longer than 50 ms. Frames carry the board's own time if it
//! has one (see `clock`), else the time of their arrival, in nanoseconds since the port was first opened.
//!
//! A port that disappears is reported once ([`SourceReading::Disconnected`]). It is then searched four times a second, by
//! the board's serial number if the system gives one, and opened again. End of file, `BrokenPipe` and EIO all
//! mean that the port has disappeared; reading it again would spin.

mod backlog;
mod intake;
mod listen;
mod port;
mod sequence;

pub use listen::{PortListener, PortReport};
pub use port::serial_number;

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::time::{Duration, Instant};

use serialport::SerialPort;

use super::clock::now;
use super::wire::FormatChoice;
use super::{Source, SourceError, SourcePace, SourceReading};
use crate::pad::Pad;
use crate::types::Nanos;
use backlog::Backlog;
use intake::FrameIntake;
use port::Identity;

/// Baud rate of most boards.
pub const DEFAULT_BAUD: u32 = 115_200;
/// How often a port that has disappeared is searched.
const RETRY: Duration = Duration::from_millis(250);
/// Longest sleep of one reading while the port is away.
const NAP: Duration = Duration::from_millis(50);

/// A board on a serial port as a source.
pub struct SerialSource {
    path: String,
    baud: u32,
    identity: Option<Identity>,
    /// None while the board is away.
    device: Option<Box<dyn SerialPort>>,
    intake: FrameIntake,
    readings: VecDeque<SourceReading>,
    started: Instant,
    /// When the port was last opened; none before the first reading, which may be long after.
    opened_ns: Option<Nanos>,
    /// While frames from before the first reading arrive.
    backlog: Option<Backlog>,
    next_try: Instant,
    buffer: Vec<u8>,
}

impl SerialSource {
    /// Opens a port with a board of this pad and format.
    ///
    /// # Errors
    /// The port cannot be opened.
    pub fn open(
        path: &str,
        baud: u32,
        pad: &Pad,
        format: FormatChoice,
    ) -> Result<Self, SourceError> {
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
            intake: FrameIntake::new(pad, format),
            readings: VecDeque::new(),
            started: now,
            opened_ns: None,
            backlog: None,
            next_try: now,
            buffer: vec![0; 4096],
        })
    }

    fn now_ns(&self) -> Nanos {
        Nanos::try_from(self.started.elapsed().as_nanos()).unwrap_or(Nanos::MAX)
    }

    /// Reads what has arrived and sends what the board needs.
    fn exchange(&mut self, mut device: Box<dyn SerialPort>) -> Result<(), SourceError> {
        if self.opened_ns.is_none() {
            let asked_ns = self.now_ns();
            self.opened_ns = Some(asked_ns);
            self.backlog = Backlog::at_first_reading(asked_ns);
        }
        if self.backlog.is_some() {
            // Without it, a read waits longer: the backlog then ends later.
            let _ = device.set_timeout(backlog::WAIT);
        }
        let received = match device.read(&mut self.buffer) {
            Ok(0) => return self.report_gone(),
            Ok(count) => count,
            Err(error) => match error.kind() {
                ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted => 0,
                _ => return self.report_gone(),
            },
        };
        let now_ns = self.now_ns();
        let opened_ns = self.opened_ns.unwrap_or(now_ns);
        let has_ended = |backlog: &mut Backlog| backlog.ends_with(received, now_ns);
        if let Some(ended) = self.backlog.take_if(has_ended) {
            let _ = device.set_timeout(port::READ_TIMEOUT);
            if ended.dropped() > 0 {
                tracing::info!(
                    "{} frames from before the first reading are not played: they are too old",
                    ended.dropped()
                );
            }
        }
        let bytes = &self.buffer[..received];
        self.intake
            .feed(now_ns, opened_ns, bytes, &mut self.readings)?;
        if let Some(backlog) = &mut self.backlog {
            let unsure = self.intake.drop_unsure();
            backlog.drop_frames(&mut self.readings, unsure, self.intake.channels());
        }
        if let Some(command) = self.intake.poll_command(now_ns, opened_ns)
            && let Err(error) = device.write_all(&command)
            && error.kind() != ErrorKind::TimedOut
        {
            return self.report_gone();
        }
        self.device = Some(device);
        Ok(())
    }

    fn report_gone(&mut self) -> Result<(), SourceError> {
        self.readings.push_back(SourceReading::Disconnected {
            reason: format!(
                "Pad disconnected: waiting for {}; all keys are released",
                self.path
            ),
        });
        self.next_try = now() + RETRY;
        Ok(())
    }

    /// Searches the board, or sleeps until the next search.
    fn search(&mut self) {
        let left = self.next_try.saturating_duration_since(now());
        if !left.is_zero() {
            std::thread::sleep(left.min(NAP));
            return;
        }
        self.next_try = now() + RETRY;
        let found = port::find(&self.path, self.identity.as_ref())
            .and_then(|path| Some((port::open(&path, self.baud).ok()?, path)));
        if let Some((device, path)) = found {
            tracing::warn!("{path}: pad connected again");
            self.path = path;
            self.device = Some(device);
            self.opened_ns = Some(self.now_ns());
            self.intake.reopened();
        }
    }
}

impl Source for SerialSource {
    fn pace(&self) -> SourcePace {
        SourcePace::ByDevice
    }

    fn read_in_parts(&mut self) {
        self.intake.hand_on_parts();
    }

    fn require_frames(&mut self) {
        self.intake.require_frames();
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        if self.readings.is_empty() {
            match self.device.take() {
                Some(device) => self.exchange(device)?,
                None => self.search(),
            }
        }
        Ok(self.readings.pop_front().unwrap_or(SourceReading::Idle))
    }
}

impl Drop for SerialSource {
    fn drop(&mut self) {
        // A board that does not receive this any more does not need it.
        if let Some(device) = &mut self.device {
            let _ = device.write_all(self.intake.stop_command());
        }
    }
}
