//! The arguments as given. Names are a contract: other people's scripts use them.

mod board;
mod recordings;
mod study;
mod values;

pub(super) use board::{BoardArgs, DeviceArgs, LayoutArg, ListenArgs};
pub(super) use recordings::{ExportArgs, ExportFormat, RecoverArgs, ReplayArgs};
pub(super) use study::{AccuracyArgs, StudyArgs, StudyCommand};
pub(super) use values::{OutputArg, PrintArg, SourceArg};

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::types::Method;
use values::{points, snr};

/// Play games on a soft sheet of hydrogel.
///
/// Without a command it opens the window on the simulated pad; where there is no display, it plays a scripted level and
/// shows it here. Nothing is sent to your desktop until you say so.
#[derive(Debug, Parser)]
#[command(
    name = "gelpad",
    version,
    after_help = "Example: gelpad play super-mario --source serial:/dev/ttyACM0"
)]
pub(super) struct Arguments {
    /// Say more (-vv: even more); RUST_LOG does the same in detail
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
    #[command(subcommand)]
    pub command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Play: touches become key events
    Play(PlayArgs),
    /// Play a recording again, or turn frames into touches or events, as fast as it goes
    Replay(ReplayArgs),
    /// Save what a damaged recording holds
    Recover(RecoverArgs),
    /// Turn a recording into what other programs read
    Export(ExportArgs),
    /// What a board sends: rate, values, order, best guess, first bad line
    Listen(ListenArgs),
    /// A simulated board on a pseudo-terminal that speaks a wire format
    Device(DeviceArgs),
    /// Learn where a pad is pressed, from presses at known places
    Calibrate(CalibrateArgs),
    /// Look at pads
    Pad {
        #[command(subcommand)]
        command: PadCommand,
    },
    /// Look at profiles
    Profile {
        #[command(subcommand)]
        command: ProfileCommand,
    },
    /// Find out which pad to build
    Study {
        #[command(subcommand)]
        command: StudyCommand,
    },
    /// Find out how well a pad's touches can be told, and what bounds it
    Accuracy(AccuracyArgs),
    /// Release the keys of the gelpad that starts this, when that is killed or stopped
    #[cfg(target_os = "linux")]
    #[command(hide = true)]
    Watch {
        /// How
        #[arg(value_enum)]
        way: WayArg,
        /// For X11: a window of its connection
        #[arg(long, default_value_t = 0)]
        window: u32,
    },
    /// Find out whether this machine can play, and what to do where it cannot
    Doctor(DoctorArgs),
}

#[cfg(target_os = "linux")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum WayArg {
    /// By releases on the X11 display
    X11,
    /// By cutting the connection on standard output
    Cut,
}

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad doctor                            each line is ok, or what is wrong and the command that mends it
  sudo gelpad doctor --install-rule        lets who sits at this machine make gamepads; says first what it will do

Exit code 1 if play would not work. It makes a gamepad for a second, and presses on X11 a key that has no meaning.")]
pub(super) struct DoctorArgs {
    /// Write the udev rule for gamepads and FTDI adapters, after saying what will be done
    #[arg(long)]
    pub install_rule: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad play                                      the level, on the simulated pad
  gelpad play super-mario --source serial:/dev/ttyACM0
  gelpad play ./mine.toml --source simulated:touches.txt --output trace --headless

A touch script, for simulated:SCRIPT (milliseconds, finger, millimetres from the bottom-left):
  t:1000 down 1 80 30           a finger of 7 mm radius that raises the conductivity by 1.2
  t:1000 down 2 20 50 6 1.5     the same with its radius (mm) and rise
  t:1040 move 1 82 31
  t:1080 up 1
  t:2000 end                    else half a second after the last line

Boards, for serial:PORT: `gelpad listen PORT` tells what one sends, docs/wire.md describes the formats. By itself gelpad
finds out the format, the order and the sign; --format NAME:rotated, flipped or plain declares the order instead.")]
pub(super) struct PlayArgs {
    /// A shipped profile, or a file (an argument with a `/` or ending in `.toml`) [default: super-mario, or the recording's own]
    pub profile: Option<String>,
    /// One person's settings over the profile: a name (users/NAME.toml here, among your own, or shipped) or a file
    #[arg(long, value_name = "NAME")]
    pub user: Option<String>,
    /// Play another profile while the program that its `[match]` names runs (Linux)
    #[arg(long = "match")]
    pub follow: bool,
    /// A shipped pad, or a file [default: edinburgh-lattice, or the recording's own]
    #[arg(long)]
    pub pad: Option<String>,
    /// Where frames come from: `simulated[:SCRIPT]`, `serial:PORT` or `replay:FILE`; `gamepad`: a gamepad or switch instead of a pad
    #[arg(long, default_value = "simulated")]
    pub source: SourceArg,
    /// Where events go
    #[arg(long, value_enum, default_value_t = OutputArg::Auto)]
    pub output: OutputArg,
    #[command(flatten)]
    pub board: BoardArgs,
    /// How images are made: tikhonov, noser, smooth or l1 [default: what profile or pad say, else noser]
    #[arg(long)]
    pub method: Option<Method>,
    /// What `gelpad calibrate` saved: places and force as presses have shown them
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
    /// Record the session: every input, touch and event, to replay and export
    #[arg(long, value_name = "FILE.mcap")]
    pub record: Option<PathBuf>,
    /// Send touches on as TUIO 1.1 (2Dcur) by UDP
    #[arg(long, value_name = "HOST:PORT")]
    pub tuio: Option<String>,
    /// No live view, even in a terminal
    #[arg(long)]
    pub headless: bool,
    /// Signal-to-noise ratio of the simulated pad, dB
    #[arg(long, value_name = "DB", default_value_t = 60.0, value_parser = snr)]
    pub snr: f64,
    /// Seed of the simulated noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad calibrate --source serial:/dev/ttyACM0 --points 50 --presses mine.csv
    press each shown place once; learns from them and saves what play and replay --calibration take
  gelpad calibrate --presses mine.csv -o mine.json
    learns again from what was recorded
  gelpad calibrate --presses train.csv --evaluate test.csv
    places test.csv by voltages alone; needs no pad, prints one JSON object
  gelpad calibrate --source serial:/dev/ttyACM0 --recommend anna
    asks for short, long and double presses, and writes the settings that suit the person who made them

Presses are CSV: x_mm,y_mm,d0,d1,... with differences pressed - unpressed in any unit; recordings have
force,model_x_mm,model_y_mm before d0, and can be saved as a calibration.")]
pub(super) struct CalibrateArgs {
    /// A shipped pad, or a file (an argument with a `/` or ending in `.toml`)
    #[arg(long, default_value = crate::pad::DEFAULT_PAD)]
    pub pad: String,
    /// Presses to learn from; with --source, where the recorded ones go
    #[arg(long, value_name = "FILE", required_unless_present = "source")]
    pub presses: Option<PathBuf>,
    /// Where the calibration goes [default: PAD.calibration.json beside the pad's file, or here]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Place these presses instead of saving, and print how far off they are
    #[arg(long, value_name = "FILE", conflicts_with_all = ["source", "output"])]
    pub evaluate: Option<PathBuf>,
    /// Record: simulated (a robot presses), serial:PORT or replay:FILE
    #[arg(long)]
    pub source: Option<SourceArg>,
    /// How many places to press
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = points)]
    pub points: usize,
    /// Ask for presses instead, and write settings that suit this person: users/NAME.toml here, or -o FILE
    #[arg(long, value_name = "NAME", requires = "source", conflicts_with_all = ["presses", "evaluate"])]
    pub recommend: Option<String>,
    /// The profile whose regions are pressed for --recommend
    #[arg(long, default_value = "super-mario-classified")]
    pub profile: String,
    /// How images are made while recording: tikhonov, noser, smooth or l1 [default: what the pad says, else noser]
    #[arg(long)]
    pub method: Option<Method>,
    /// Signal-to-noise ratio of the simulated pad, dB
    #[arg(long, value_name = "DB", default_value_t = 60.0, value_parser = snr)]
    pub snr: f64,
    #[command(flatten)]
    pub board: BoardArgs,
    /// Seed of the simulated noise and of the robot's errors
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

#[derive(Debug, Subcommand)]
#[command(after_help = "Example: gelpad pad check ./my-pad.toml")]
pub(super) enum PadCommand {
    /// The shipped pads
    List,
    /// Whether a pad can be built and measured
    #[command(after_help = "Example: gelpad pad check ./my-pad.toml")]
    Check {
        /// A shipped pad, or a file
        #[arg(default_value = crate::pad::DEFAULT_PAD)]
        pad: String,
    },
    /// What a pad is: a drawing and its numbers; --toml prints its text, to copy and edit
    #[command(after_help = "Example: gelpad pad show edinburgh-lattice --toml > my-pad.toml")]
    Show {
        /// A shipped pad, or a file
        #[arg(default_value = crate::pad::DEFAULT_PAD)]
        pad: String,
        /// Its text
        #[arg(long)]
        toml: bool,
    },
}

#[derive(Debug, Subcommand)]
#[command(after_help = "Example: gelpad profile check ./mine.toml")]
pub(super) enum ProfileCommand {
    /// The shipped profiles
    List,
    /// Whether a profile is sound, and what is odd about it
    #[command(after_help = "Example: gelpad profile check ./mine.toml --user anna")]
    Check {
        /// A shipped profile, or a file
        #[arg(default_value = crate::profile::DEFAULT_PROFILE)]
        profile: String,
        /// With one person's settings
        #[arg(long, value_name = "NAME")]
        user: Option<String>,
    },
    /// The JSON schema of profiles, for editors
    #[command(after_help = "Example: gelpad profile schema > profile.schema.json")]
    Schema,
    /// What a profile does: a map, its bindings, and where each value comes from
    #[command(after_help = "\
Examples:
  gelpad profile show super-mario --toml > mine.toml      its text, to copy and edit
  gelpad profile show ./mine.toml --print regions.svg     to print, cut out and lay on the pad")]
    Show(ShowArgs),
}

#[derive(Args, Debug)]
pub(super) struct ShowArgs {
    /// A shipped profile, or a file
    #[arg(default_value = crate::profile::DEFAULT_PROFILE)]
    pub profile: String,
    /// With one person's settings
    #[arg(long, value_name = "NAME")]
    pub user: Option<String>,
    /// Its text
    #[arg(long, conflicts_with_all = ["svg", "png", "print"])]
    pub toml: bool,
    /// Draw the regions as SVG
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Draw the regions as PNG
    #[arg(long, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// Draw the regions as SVG at true scale on a sheet of A4, with a ruler
    #[arg(long, value_name = "FILE")]
    pub print: Option<PathBuf>,
    /// The pad whose size the drawings have
    #[arg(long, default_value = crate::pad::DEFAULT_PAD)]
    pub pad: String,
}
