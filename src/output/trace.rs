//! Events as text, a line each, as `--print events` documents them.

use std::io::Write;

use super::{Device, OutputError};
use crate::types::{Event, Output};

/// Writes event lines.
pub struct Trace<W: Write> {
    sink: W,
}

impl<W: Write> Trace<W> {
    /// A trace into a sink.
    pub fn new(sink: W) -> Self {
        Self { sink }
    }
}

impl<W: Write + Send> Device for Trace<W> {
    fn name(&self) -> &str {
        "trace"
    }

    fn takes(&self, _: Output) -> bool {
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
