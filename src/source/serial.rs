//! A board on a serial port (or a pseudo-terminal).
//!
//! Frames are stamped on arrival, in nanoseconds since the port was opened. A port that goes away ends the source
//! at once: hang-ups come back as end of file, `BrokenPipe` or EIO, and asking again would spin.

use std::io::{ErrorKind, Read};
use std::time::{Duration, Instant};

use serialport::SerialPort;

use super::wire::Decoded;
use super::wire::openeit::OpenEit;
use super::{Pace, Reading, Source, SourceError};
use crate::types::{Frame, Nanos};

/// Speed of OpenEIT's boards.
const BAUD: u32 = 115_200;
/// Longest wait in one call of `read`.
const PATIENCE: Duration = Duration::from_millis(50);

/// A port that is read.
pub struct SerialSource {
    port: String,
    device: Box<dyn SerialPort>,
    decoder: OpenEit,
    decoded: std::collections::VecDeque<Decoded>,
    opened: Instant,
    buffer: Vec<u8>,
}

impl SerialSource {
    /// Opens a port whose board sends frames of so many channels in OpenEIT's text format.
    ///
    /// # Errors
    /// A port that cannot be opened.
    #[allow(
        clippy::disallowed_methods,
        reason = "a board's frames are stamped on arrival"
    )]
    pub fn open(port: &str, channels: usize) -> Result<Self, SourceError> {
        let device = serialport::new(port, BAUD)
            .timeout(PATIENCE)
            .open()
            .map_err(|error| SourceError::Open {
                port: port.to_owned(),
                error,
            })?;
        Ok(Self {
            port: port.to_owned(),
            device,
            decoder: OpenEit::new(channels),
            decoded: std::collections::VecDeque::new(),
            opened: Instant::now(),
            buffer: vec![0; 4096],
        })
    }

    fn now_ns(&self) -> Nanos {
        Nanos::try_from(self.opened.elapsed().as_nanos()).unwrap_or(Nanos::MAX)
    }
}

impl Source for SerialSource {
    fn pace(&self) -> Pace {
        Pace::ByDevice
    }

    fn read(&mut self) -> Result<Reading, SourceError> {
        if self.decoded.is_empty() {
            let gone = || SourceError::Gone {
                port: self.port.clone(),
            };
            match self.device.read(&mut self.buffer) {
                Ok(0) => return Err(gone()),
                Ok(count) => {
                    let mut decoded = Vec::new();
                    self.decoder.feed(&self.buffer[..count], &mut decoded);
                    self.decoded.extend(decoded);
                }
                Err(error) => match error.kind() {
                    ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted => {}
                    _ => return Err(gone()),
                },
            }
        }
        Ok(match self.decoded.pop_front() {
            Some(Decoded::Volts(volts)) => Reading::Frame(Frame {
                t_ns: self.now_ns(),
                volts,
            }),
            Some(Decoded::Garbled { reason }) => Reading::Skipped { reason },
            None => Reading::Idle,
        })
    }
}
