//! What is to be played: pad, profile, source, output and options.

use std::path::PathBuf;

use crate::runtime::ExistingFile;
use crate::source::Disturbance;
use crate::source::serial::DEFAULT_BAUD;
use crate::source::wire::FormatChoice;
use crate::types::Method;

/// Where frames come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SourceChoice {
    /// The simulated pad, pressed in the window.
    Simulated,
    /// The simulated pad, pressed by the built-in level script.
    Level,
    /// The simulated pad, pressed by a touch script.
    Script(PathBuf),
    /// A board on a serial port.
    Serial(String),
    /// A recording, or frames as CSV.
    Replay(PathBuf),
    /// Gamepads and switches instead of a pad.
    Gamepad,
}

/// Where events go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputChoice {
    /// Nowhere: a trial.
    Nothing,
    /// The best output of this computer; text if there is none.
    Auto,
    /// Keyboard and mouse of the desktop, or of the kernel without a desktop.
    Keyboard,
    /// Gamepad, keyboard and mouse of the Linux kernel.
    Gamepad,
    /// Text.
    Trace,
}

/// Format and speed of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoardLine {
    /// Wire format.
    pub format: FormatChoice,
    /// Speed of the serial port, baud.
    pub baud: u32,
}

impl Default for BoardLine {
    fn default() -> Self {
        Self {
            format: FormatChoice::default(),
            baud: DEFAULT_BAUD,
        }
    }
}

/// Noise of the simulated pad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseLevel {
    /// Signal-to-noise ratio, dB.
    pub snr_db: f64,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// The ratio is never NaN.
impl Eq for NoiseLevel {}

impl Default for NoiseLevel {
    fn default() -> Self {
        Self {
            snr_db: 60.0,
            seed: 1,
        }
    }
}

/// What is to be played.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlayRequest {
    /// A shipped pad, or a file.
    pub pad: String,
    /// A shipped profile, or a file.
    pub profile: String,
    /// With a recording as the source: play its pad and calibration instead of `pad`.
    pub recorded_pad: bool,
    /// With a recording as the source: play its profile instead of `profile`.
    pub recorded_profile: bool,
    /// One user's settings.
    pub user: Option<String>,
    /// Follow the running program: play the profile whose `[match]` names it.
    pub match_programs: bool,
    /// Where frames come from.
    pub source: SourceChoice,
    /// Format and speed of a board.
    pub board: BoardLine,
    /// Noise of the simulated pad.
    pub noise: NoiseLevel,
    /// Frames a second of a simulated pad under a script whose drives are read one after another; none: at one moment.
    pub in_turn_hz: Option<u32>,
    /// What disturbs the readings of the simulated pad.
    pub disturbances: Vec<Disturbance>,
    /// Where events go.
    pub output: OutputChoice,
    /// Whether a trace is printed on stdout; otherwise it is dropped.
    pub trace_on_stdout: bool,
    /// Whether the pad of a board is played as drawn, and not identified from its readings.
    pub as_drawn: bool,
    /// The reconstruction method, instead of the profile's or the pad's.
    pub method: Option<Method>,
    /// A saved calibration.
    pub calibration: Option<PathBuf>,
    /// Where the recording goes, if one is made.
    pub record: Option<PathBuf>,
    /// Whether readings are rounded to a part of their noise, and the recording only names matrix and response table, which each
    /// machine solves.
    pub slim: bool,
    /// What happens to a file that stands there.
    pub existing: ExistingFile,
    /// Receiver of touches as TUIO, `HOST:PORT`.
    pub tuio: Option<String>,
}

impl Default for PlayRequest {
    fn default() -> Self {
        Self {
            pad: crate::pad::DEFAULT_PAD.to_owned(),
            profile: crate::profile::DEFAULT_PROFILE.to_owned(),
            recorded_pad: false,
            recorded_profile: false,
            user: None,
            match_programs: false,
            source: SourceChoice::Simulated,
            board: BoardLine::default(),
            noise: NoiseLevel::default(),
            in_turn_hz: None,
            disturbances: Vec::new(),
            output: OutputChoice::Nothing,
            trace_on_stdout: false,
            as_drawn: false,
            method: None,
            calibration: None,
            record: None,
            slim: false,
            existing: ExistingFile::Refuse,
            tuio: None,
        }
    }
}

impl PlayRequest {
    /// The source as a label.
    #[must_use]
    pub fn source_label(&self) -> String {
        match &self.source {
            SourceChoice::Simulated => "simulated pad, your mouse".to_owned(),
            SourceChoice::Level => "simulated pad, the level".to_owned(),
            SourceChoice::Script(script) => format!("simulated pad, {}", script.display()),
            SourceChoice::Serial(port) => port.clone(),
            SourceChoice::Replay(file) => match file.file_name() {
                Some(name) => name.to_string_lossy().into_owned(),
                None => file.display().to_string(),
            },
            SourceChoice::Gamepad => "gamepad".to_owned(),
        }
    }
}

/// The parts of a game that the arguments of `gelpad` name; the others are those of the last session.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WindowArguments {
    /// A shipped profile, or a file.
    pub profile: Option<String>,
    /// A shipped pad, or a file.
    pub pad: Option<String>,
    /// One user's settings.
    pub user: Option<String>,
    /// Where frames come from.
    pub source: Option<SourceChoice>,
    /// A saved calibration.
    pub calibration: Option<PathBuf>,
}

impl WindowArguments {
    /// A game with these parts.
    #[must_use]
    pub fn apply(self, mut request: PlayRequest) -> PlayRequest {
        if let Some(pad) = self.pad
            && pad != request.pad
        {
            request.pad = pad;
            // A calibration belongs to one pad.
            request.calibration = None;
        }
        request.profile = self.profile.unwrap_or(request.profile);
        request.user = self.user.or(request.user);
        request.source = self.source.unwrap_or(request.source);
        request.calibration = self.calibration.or(request.calibration);
        request
    }
}
