//! Where frames come from: the simulated pad, frames from a file, a board on a serial port; and gamepads, which have no frames.
//!
//! A source checks what it hands up: every frame has the pad's number of voltages, all finite, and times never
//! run backwards. What it had to skip it says, so that nothing is lost in silence.

mod arrangement;
pub mod board;
mod clock;
mod eit_folder;
pub mod eit_text;
mod files;
mod frames_csv;
#[cfg(feature = "gilrs")]
mod gamepad;
mod live;
mod noise;
mod recorded;
mod robot;
mod script;
pub mod serial;
mod simulated;
mod table;
pub mod wire;

pub use arrangement::{Arrangement, ArrangementError, plausible_counts, told as order_told};
pub use eit_folder::EitFolder;
pub use files::{FileKind, file_kind, open_file};
pub use frames_csv::FramesCsv;
#[cfg(feature = "gilrs")]
pub use gamepad::GamepadSource;
pub use live::{Hand, LiveSource};
pub use noise::Noise;
pub use recorded::RecordedFrames;
pub use robot::Robot;
pub use script::{Finger, LEVEL_SCRIPT, Script, Step, StepKind};
pub use simulated::{SimulatedPad, SimulatedSource};
pub use table::FramesTable;

use std::path::PathBuf;

use crate::eit::ForwardError;
use crate::types::{Control, Frame};

/// What a source has to say when asked.
#[derive(Clone, Debug, PartialEq)]
pub enum Reading {
    /// A frame.
    Frame(Frame),
    /// What gamepads and switches say: from a source without image.
    Control(Control),
    /// Something came that is no frame; it was skipped.
    Skipped {
        /// What was wrong with it, for the player.
        reason: String,
        /// Frames that were lost with it; 0 where the next frame's number will tell.
        frames: u64,
    },
    /// The board went away; the source looks for it and goes on when it is back.
    Gone {
        /// What happened, for the player.
        reason: String,
    },
    /// Nothing yet; ask again.
    Idle,
    /// There is no more.
    End,
}

/// Who keeps the time of a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// Whoever plays it: frames are there at once and carry the time at which they are due.
    ByStamp,
    /// The source itself: a frame is there when the device sends it.
    ByDevice,
}

/// Why a source gives no more frames.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// A file cannot be read.
    #[error("{}: {error}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// A file holds something else.
    #[error("{}:{line}: {problem}", path.display())]
    Line {
        /// Which.
        path: PathBuf,
        /// Its line, from 1.
        line: u64,
        /// What is wrong there.
        problem: String,
    },
    /// A recording cannot be read, or not further.
    #[error("{}: {error}", path.display())]
    Recording {
        /// Which.
        path: PathBuf,
        /// Why.
        error: crate::session::ReadError,
    },
    /// A finger of a script misses the pad.
    #[error("finger {id} at ({x}, {y}) mm is off the pad, which is {width} x {height} mm")]
    OffPad {
        /// Its number.
        id: u64,
        /// Where.
        x: f64,
        /// Where.
        y: f64,
        /// The pad's width, mm.
        width: f64,
        /// The pad's height, mm.
        height: f64,
    },
    /// The simulated pad cannot be solved.
    #[error("the simulated pad: {0}")]
    Simulation(#[from] ForwardError),
    /// A serial port cannot be opened.
    #[error(
        "{port}: {error}\n  help: plug the board in, close what else holds the port, and join the group `dialout` if permission is denied"
    )]
    Open {
        /// Its path.
        port: String,
        /// Why.
        error: serialport::Error,
    },
    /// Gamepads cannot be watched.
    #[error("gamepads cannot be watched: {reason}")]
    Gamepads {
        /// Why.
        reason: String,
    },
    /// A port that is listened to went away.
    #[error("{port}: the board is gone (unplugged or reset)")]
    Gone {
        /// Its path.
        port: String,
    },
    /// A board's frames do not fit the pad.
    #[error(transparent)]
    Arrangement(ArrangementError),
}

/// Something that gives frames.
pub trait Source: Send {
    /// Who keeps its time.
    fn pace(&self) -> Pace;

    /// The next reading. Returns within a tenth of a second, with [`Reading::Idle`] if need be.
    ///
    /// # Errors
    /// When there will be no more frames, and why.
    fn read(&mut self) -> Result<Reading, SourceError>;
}
