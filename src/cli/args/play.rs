//! Arguments of `gelpad play`.

use std::path::PathBuf;

use clap::Args;

use super::board::BoardArgs;
use super::values::{OutputArg, snr, source};
use crate::app::calibration::pad_and_calibration;
use crate::app::services::{NoiseLevel, OutputChoice, PlayRequest, SourceChoice};
use crate::runtime::ExistingFile;
use crate::source::Disturbance;
use crate::types::Method;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad play                                      the level on the simulated pad
  gelpad play super-mario --source serial:/dev/ttyACM0
  gelpad play ./mine.toml --source simulated:touches.txt --output trace --headless

A touch script, for simulated:SCRIPT (milliseconds, finger, millimetres from the bottom-left):
  t:1000 down 1 80 30           finger 1: radius 7 mm, conductivity change 1.2
  t:1000 down 2 20 50 6 1.5     finger 2: radius 6 mm, conductivity change 1.5
  t:1040 move 1 82 31
  t:1080 up 1
  t:2000 end                    default: half a second after the last line

Boards, for serial:PORT: `gelpad listen PORT` shows what a board sends; docs/wire.md describes the formats. gelpad detects
format, order and sign; --format NAME:rotated, NAME:flipped or NAME:plain sets the order instead.")]
pub(in crate::cli) struct PlayArgs {
    /// A shipped profile, or a file (contains `/` or ends in `.toml`) [default: super-mario, or the recording's own]
    pub profile: Option<String>,
    /// Settings of one user, applied over the profile: a file, or a name (users/NAME.toml here or in your own gelpad folder, or a shipped one)
    #[arg(long, value_name = "NAME")]
    pub user: Option<String>,
    /// Follow the running program: play the profile whose `[match]` names it (Linux)
    #[arg(long = "match")]
    pub follow: bool,
    /// A shipped pad, or a file [default: edinburgh-lattice, or the recording's own]
    #[arg(long)]
    pub pad: Option<String>,
    /// Where frames come from: `simulated[:SCRIPT]`, `serial:PORT` or `replay:FILE`; `gamepad`: a gamepad or switch instead of a pad
    #[arg(long, default_value = "simulated", value_parser = source)]
    pub source: SourceChoice,
    /// Where events go
    #[arg(long, value_enum, default_value_t = OutputArg::Auto)]
    pub output: OutputArg,
    #[command(flatten)]
    pub board: BoardArgs,
    /// Reconstruction: tikhonov, noser, smooth or l1 [default: the profile's or the pad's, else noser]
    #[arg(long)]
    pub method: Option<Method>,
    /// What `gelpad calibrate` made: a calibration, which corrects place and force of touches, or a learned pad (FILE.toml)
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
    /// Play a board's pad as drawn: do not identify it from its readings at rest
    #[arg(long)]
    pub as_drawn: bool,
    /// Record the session, to replay and export it: every input, touch and event
    #[arg(long, value_name = "FILE.mcap")]
    pub record: Option<PathBuf>,
    /// Record a quarter as much: readings are rounded to a part of their noise before they are played, and matrix and
    /// response table are only named, and solved again to replay
    #[arg(long, requires = "record")]
    pub slim: bool,
    /// Replace the file of --record if it exists
    #[arg(long, requires = "record")]
    pub force: bool,
    /// Send touches as TUIO 1.1 (2Dcur) over UDP
    #[arg(long, value_name = "HOST:PORT")]
    pub tuio: Option<String>,
    /// Show no live view, even in a terminal
    #[arg(long)]
    pub headless: bool,
    /// Signal-to-noise ratio of the simulated pad, dB
    #[arg(long, value_name = "DB", default_value_t = 60.0, value_parser = snr)]
    pub snr: f64,
    /// Read the drives of the simulated pad one after another, HZ frames a second, as slow boards do [default: all at once, 100]
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(1..=1000), conflicts_with_all = ["disturb", "slim"])]
    pub in_turn: Option<u32>,
    /// Disturb the readings as a real board would, such as adc:12,spikes:0.3 (`gelpad accuracy --help` lists the names)
    #[arg(long, value_name = "NAME[:VALUE],...", value_delimiter = ',')]
    pub disturb: Vec<Disturbance>,
    /// Seed of the simulated noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

impl PlayArgs {
    /// The request that these arguments describe.
    pub(in crate::cli) fn to_request(&self, trace_on_stdout: bool) -> PlayRequest {
        let is_simulated = matches!(self.source, SourceChoice::Level | SourceChoice::Script(_));
        let default = PlayRequest::default();
        let (pad, calibration) = pad_and_calibration(self.pad.clone(), self.calibration.clone());
        PlayRequest {
            recorded_pad: pad.is_none(),
            pad: pad.unwrap_or(default.pad),
            recorded_profile: self.profile.is_none(),
            profile: self.profile.clone().unwrap_or(default.profile),
            user: self.user.clone(),
            match_programs: self.follow,
            source: self.source.clone(),
            board: self.board.line(),
            noise: NoiseLevel {
                snr_db: self.snr,
                seed: self.seed,
            },
            in_turn_hz: self.in_turn,
            disturbances: self.disturb.clone(),
            // A demonstration must not type into the window that has the focus.
            output: match self.output {
                OutputArg::Auto if is_simulated => OutputChoice::Trace,
                output => output.into(),
            },
            trace_on_stdout,
            as_drawn: self.as_drawn,
            method: self.method,
            calibration,
            record: self.record.clone(),
            slim: self.slim,
            existing: match self.force {
                true => ExistingFile::Replace,
                false => ExistingFile::Refuse,
            },
            tuio: self.tuio.clone(),
        }
    }
}
