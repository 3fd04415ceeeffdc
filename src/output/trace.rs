//! Events as text, one line each, in the format of `--print events`.

use std::io::Write;

use super::{OutputDevice, OutputError};
use crate::types::{Event, Output};

/// Writes every event as a line.
pub struct Trace<W: Write> {
    sink: W,
}

impl<W: Write> Trace<W> {
    /// A trace that writes to `sink`.
    pub fn new(sink: W) -> Self {
        Self { sink }
    }
}

impl<W: Write + Send> OutputDevice for Trace<W> {
    fn name(&self) -> &str {
        "trace"
    }

    fn supports(&self, _: Output) -> bool {
        true
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        writeln!(self.sink, "{event}").map_err(refused)
    }

    fn flush(&mut self) -> Result<(), OutputError> {
        self.sink.flush().map_err(refused)
    }
}

fn refused(error: std::io::Error) -> OutputError {
    if error.kind() == std::io::ErrorKind::BrokenPipe {
        return OutputError::Closed;
    }
    OutputError::Refused {
        device: "trace",
        reason: error.to_string(),
    }
}
