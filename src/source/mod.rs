//! Where frames come from: the simulated pad, files, a board on a serial port; and gamepads, which have no frames.
//!
//! A source checks its frames: each has the pad's number of voltages, all finite, and times never run
//! backwards. Everything that it skips is reported.

mod arrangement;
pub mod board;
mod clock;
mod disturbance;
mod disturbed;
mod disturber;
mod eit_folder;
pub mod eit_text;
mod files;
mod frames_csv;
#[cfg(gamepads)]
mod gamepad;
mod leading;
mod live;
mod noise;
mod own_order;
mod recorded;
mod robot;
mod rounded;
mod scanned;
mod script;
pub mod serial;
mod simulated;
mod skip_log;
mod table;
pub mod wire;

pub use arrangement::{Arrangement, ArrangementError, PartPlace, describe_order, plausible_counts};
pub use disturbance::{DISTURBANCE_NAMES, Disturbance, UnknownDisturbance};
pub use disturbed::DisturbedSource;
pub use disturber::Disturber;
pub use eit_folder::EitFolder;
pub use files::{FileKind, file_kind, open_file};
pub use frames_csv::FramesCsv;
#[cfg(gamepads)]
pub use gamepad::GamepadSource;
pub use live::{LiveFingers, LiveSource};
pub use noise::Noise;
pub use recorded::RecordedFrames;
pub use robot::RobotSource;
pub use rounded::RoundedSource;
pub use scanned::PartSplitter;
pub use script::{Finger, FingerAction, Script, ScriptStep};
pub use simulated::{SIMULATED_FRAME_NS, SimulatedPad, SimulatedSource};
pub use skip_log::{NoFrames, SkipLog};
pub use table::FramesTable;

use std::path::{Path, PathBuf};

use crate::eit::ForwardError;
use crate::types::{Control, Frame, Part};

/// A reading of a source.
#[derive(Clone, Debug, PartialEq)]
pub enum SourceReading {
    /// A frame.
    Frame(Frame),
    /// Readings of a frame that is still being read, see [`Source::read_in_parts`].
    Part(Part),
    /// The state of gamepads and switches, from a source without images.
    Control(Control),
    /// Input that is not a frame was skipped.
    Skipped {
        /// What was wrong, for people.
        reason: String,
        /// Number of frames that were lost with it; 0 if the next frame's number will tell.
        frames: u64,
    },
    /// The board was disconnected; the source waits until it is back.
    Disconnected {
        /// What happened, for people.
        reason: String,
    },
    /// Nothing yet.
    Idle,
    /// There are no more readings.
    End,
}

/// What determines when a frame is played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourcePace {
    /// The time stamps: frames are available immediately and are played when they are due.
    ByStamp,
    /// The device: a frame is available when the device sends it.
    ByDevice,
}

/// The reason why a source ends.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// A file cannot be read.
    #[error("{}: {error}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The cause.
        error: std::io::Error,
    },
    /// A line of a file is wrong.
    #[error("{}:{line}: {problem}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// The mistake.
        problem: String,
    },
    /// A recording cannot be read, or only in part.
    #[error("{}: {error}", path.display())]
    Recording {
        /// The file.
        path: PathBuf,
        /// The cause.
        error: crate::session::ReadError,
    },
    /// A finger of a script is off the pad.
    #[error("finger {id} at ({x}, {y}) mm is off the pad, which is {width} x {height} mm")]
    OffPad {
        /// Number of the finger.
        id: u64,
        /// x, mm.
        x: f64,
        /// y, mm.
        y: f64,
        /// The pad's width, mm.
        width: f64,
        /// The pad's height, mm.
        height: f64,
    },
    /// The simulated pad cannot be solved.
    #[error("the simulated pad cannot be solved: {0}")]
    Simulation(#[from] ForwardError),
    /// A serial port cannot be opened.
    #[error(
        "{port}: {error}\n  help: plug the board in, close other programs that use the port, and join the group `dialout` if permission is denied"
    )]
    Open {
        /// Path of the port.
        port: String,
        /// The cause.
        error: serialport::Error,
    },
    /// Gamepads cannot be watched.
    #[error("cannot open gamepads: {reason}")]
    Gamepads {
        /// The cause.
        reason: String,
    },
    /// The board was disconnected while `gelpad listen` was running.
    #[error("{port}: pad disconnected (unplugged or reset)")]
    Disconnected {
        /// Its path.
        port: String,
    },
    /// A board sends something else than frames, see [`Source::require_frames`].
    #[error(
        "{bytes} bytes arrived in {seconds} s, but no frame{last}\n  help: check the baud rate (--baud) and the format (--format); `gelpad listen` shows what the board sends"
    )]
    NoFrame {
        /// Bytes that arrived since the port was opened.
        bytes: u64,
        /// Since the first of them, s.
        seconds: u64,
        /// The last garbled frame, for people; empty if nothing looked like one.
        last: String,
    },
    /// A board's frames do not fit the pad.
    #[error(transparent)]
    Arrangement(ArrangementError),
}

impl SourceError {
    fn file(path: &Path, error: std::io::Error) -> Self {
        Self::File {
            path: path.to_owned(),
            error,
        }
    }

    fn line(path: &Path, line: u64, problem: impl Into<String>) -> Self {
        Self::Line {
            path: path.to_owned(),
            line,
            problem: problem.into(),
        }
    }
}

/// Something that produces frames.
pub trait Source: Send {
    /// What determines when a frame is played.
    fn pace(&self) -> SourcePace;

    /// From now on frames may be handed on part by part, where the source reads them so.
    fn read_in_parts(&mut self) {}

    /// From now on a board that sends something for long, but no frame, is an error: nothing will come of waiting.
    fn require_frames(&mut self) {}

    /// The next reading. Returns within a tenth of a second, with [`SourceReading::Idle`] if there is nothing.
    ///
    /// # Errors
    /// The reason why there are no more frames.
    fn read(&mut self) -> Result<SourceReading, SourceError>;
}
