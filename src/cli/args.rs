//! The arguments as given. Names are a contract: other people's scripts use them.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use super::device::{Between, Loose};
use crate::source::board::Every;
use crate::source::serial::DEFAULT_BAUD;
use crate::source::wire::Format;
use crate::study::Vary;
use crate::study::job::Shard;
use crate::study::width::Rank;
use crate::types::Method;

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
  gelpad accuracy --out accuracy                                  about a minute on two cores
  gelpad accuracy --pad ./my-pad.toml --snr 70,60,45 --out mine
  gelpad accuracy --pad round-tank --quick --out tank             some ten seconds: whether all works, not how well")]
pub(super) struct AccuracyArgs {
    /// Where report, picture, JSON and CSV go
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// A shipped pad, or a file (an argument with a `/` or ending in `.toml`)
    #[arg(long, default_value = crate::pad::DEFAULT_PAD)]
    pub pad: String,
    /// Signal-to-noise ratios, dB
    #[arg(long, value_name = "DB,...", value_delimiter = ',', value_parser = snr, default_value = "80,60,50,40")]
    pub snr: Vec<f64>,
    /// How images are made: tikhonov, noser, smooth or l1 [default: what the pad says, else noser]
    #[arg(long)]
    pub method: Option<Method>,
    /// Seed of specimens, touches and noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Few draws: whether all works, not how well
    #[arg(long)]
    pub quick: bool,
}

#[derive(Debug, Subcommand)]
#[command(after_help = "Example: gelpad study width --out width-study")]
pub(super) enum StudyCommand {
    /// How the signal depends on the width of the channels, or on any number in a pad's text
    #[command(after_help = "\
Examples:
  gelpad study width --out width-study
  gelpad study width --out pitch --vary lattice.x_lines=7..15:2 --rank bound
  gelpad study width --out part3 --shard 3/8      (a job array; then: gelpad study merge part* --out whole)")]
    Width {
        #[command(flatten)]
        common: StudyArgs,
        /// Sweep a number of the pad's text instead: PARAMETER=FROM..TO:STEP, as lattice.width=1..5:0.5
        #[arg(long, value_name = "P=A..B:STEP")]
        vary: Option<Vary>,
        /// What the variants are ranked by
        #[arg(long, value_enum, default_value_t = RankArg::Bound)]
        rank: RankArg,
        /// Fewer places
        #[arg(long)]
        quick: bool,
    },
    /// What the pad can show: five phantoms, Tikhonov and L1
    #[command(after_help = "Example: gelpad study phantoms --out phantoms")]
    Phantoms {
        #[command(flatten)]
        common: StudyArgs,
        /// It is quick as it is
        #[arg(long)]
        quick: bool,
    },
    /// Join the folders of all shards
    #[command(after_help = "Example: gelpad study merge part1 part2 --out whole")]
    Merge {
        /// The shards' folders
        #[arg(required = true)]
        folders: Vec<PathBuf>,
        /// Where the whole goes
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
}

/// What every study takes.
#[derive(Args, Debug)]
pub(super) struct StudyArgs {
    /// Where the report goes; a killed study goes on from what is there
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// A shipped pad, or a file (an argument with a `/` or ending in `.toml`)
    #[arg(long, default_value = crate::pad::DEFAULT_PAD)]
    pub pad: String,
    /// Seed of random places and noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Solve the K-th of N parts of the cases only
    #[arg(
        long,
        value_name = "K/N",
        default_value = "1/1",
        hide_default_value = true
    )]
    pub shard: Shard,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum RankArg {
    /// mean |dV| at constant current
    Change,
    /// mean |dV/V|
    Relative,
    /// how well a touch's place can be known
    Bound,
}

impl From<RankArg> for Rank {
    fn from(arg: RankArg) -> Self {
        match arg {
            RankArg::Change => Self::Change,
            RankArg::Relative => Self::Relative,
            RankArg::Bound => Self::Bound,
        }
    }
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
  gelpad listen /dev/ttyACM0                   ten seconds; a board that says nothing is sent the known start commands
  gelpad listen /dev/ttyUSB0 --mute --seconds 60 --format lines")]
pub(super) struct ListenArgs {
    /// The board's port
    pub port: String,
    /// How long to listen, s
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = above_zero)]
    pub seconds: f64,
    /// End after so many frames
    #[arg(long, value_name = "N")]
    pub frames: Option<u64>,
    /// Send nothing, whatever is heard
    #[arg(long)]
    pub mute: bool,
    #[command(flatten)]
    pub board: BoardArgs,
}

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad device --port ./board --format openeit --pad openeit-lattice
  gelpad play --pad openeit-lattice --source serial:./board --output trace      (in another terminal)
  gelpad device --port ./board --format gelpad --rate 500 --lose-bytes 1 --flip-bits 0.1
  gelpad device --port ./board --format lines:rotated --pause 5,800 --hang-up 20,1500 --lose-electrode 5@10

The pad is the simulated one, pressed by a touch script (the level by default) that begins again when it ends.")]
pub(super) struct DeviceArgs {
    /// Where the port is to be found: a link that is made there [default: where the system puts it; it is said]
    #[arg(long, value_name = "PATH")]
    pub port: Option<PathBuf>,
    /// What it speaks: openeit, square, request, lines, lines:complex, sciospec or gelpad; with :rotated or :flipped
    #[arg(long, value_name = "F")]
    pub format: Format,
    /// The pad that it reads: a shipped one, or a file
    #[arg(long, default_value = crate::pad::DEFAULT_PAD)]
    pub pad: String,
    /// What fingers do to the pad: a touch script
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// Frames a second; 0: as many as the host takes
    #[arg(long, value_name = "HZ", default_value_t = 100.0, value_parser = rate)]
    pub rate: f64,
    /// End after so many frames
    #[arg(long, value_name = "N")]
    pub frames: Option<u64>,
    /// Which readings it lists [default: the pad's; square: all pairs]
    #[arg(long, value_enum)]
    pub layout: Option<LayoutArg>,
    /// Whole counts of a converter instead of volts (gelpad)
    #[arg(long)]
    pub counts: bool,
    /// No menu at reset (openeit)
    #[arg(long)]
    pub no_menu: bool,
    /// Signal-to-noise ratio of the pad, dB
    #[arg(long, value_name = "DB", default_value_t = 60.0, value_parser = snr)]
    pub snr: f64,
    /// Drift of all voltages, % a minute
    #[arg(
        long,
        value_name = "PERCENT",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    pub drift: f64,
    /// An electrode that comes loose, and from which second on
    #[arg(long, value_name = "N[@S]")]
    pub lose_electrode: Option<Loose>,
    /// Bytes that are lost, %
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0, value_parser = percent)]
    pub lose_bytes: f64,
    /// Bits that are turned, %
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0, value_parser = percent)]
    pub flip_bits: f64,
    /// Frames of which only the first half comes, %
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0, value_parser = percent)]
    pub half_frames: f64,
    /// Every so many seconds no frame for so many milliseconds
    #[arg(long, value_name = "S,MS")]
    pub pause: Option<Every>,
    /// Every so many seconds the port goes away for so many milliseconds
    #[arg(long, value_name = "S,MS")]
    pub hang_up: Option<Every>,
    /// Every so many seconds another format for so many milliseconds
    #[arg(long, value_name = "F,S,MS")]
    pub between: Option<Between>,
    /// Seed of noise and faults
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum LayoutArg {
    /// n (n - 3) adjacent readings
    Full,
    /// the half of these that reciprocity leaves
    Half,
    /// all n x n pairs, the driven ones as zeros
    Square,
    /// opposite drive, n (n - 4)
    Opposite,
}

/// How a board on a serial port talks.
#[derive(Args, Clone, Debug)]
pub(super) struct BoardArgs {
    /// What a board sends: auto, openeit, square, request, lines, lines:complex, sciospec or gelpad
    #[arg(long, value_name = "F", default_value = "auto")]
    pub format: Format,
    /// Speed of a serial port (USB boards take any)
    #[arg(long, value_name = "BAUD", default_value_t = DEFAULT_BAUD)]
    pub baud: u32,
}

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad replay session.mcap                                    its events, as they were played
  gelpad replay session.mcap --update session.events            save them as what is expected ...
  gelpad replay session.mcap --expect session.events            ... and see whether they still come
  gelpad replay session.mcap --profile ./mine.toml --print events
  gelpad replay session.mcap --realtime --output keyboard --from 12 --to 20
  gelpad replay frames.csv --pad edinburgh-lattice --print touches")]
pub(super) struct ReplayArgs {
    /// A recording (.mcap), frames as CSV (t_ms,v0,v1,...), a folder of Sciospec's .eit files, or a table with a frame a column
    pub file: PathBuf,
    /// A shipped pad, or a file (an argument with a `/` or ending in `.toml`) [default: the recording's own; edinburgh-lattice for CSV]
    #[arg(long)]
    pub pad: Option<String>,
    /// A shipped profile, or a file [default: the recording's own; super-mario for CSV]
    #[arg(long)]
    pub profile: Option<String>,
    /// One person's settings over the profile
    #[arg(long, value_name = "NAME")]
    pub user: Option<String>,
    /// How images are made: tikhonov, noser, smooth or l1 [default: as recorded; for CSV what profile or pad say, else noser]
    #[arg(long)]
    pub method: Option<Method>,
    /// What `gelpad calibrate` saved: places and force as presses have shown them [default: the recording's own]
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
    /// touches: a JSON line a frame; events: a text line an event [default: events, unless they go elsewhere]
    #[arg(long, value_enum)]
    pub print: Option<PrintArg>,
    /// Send the events to an output
    #[arg(long, value_enum)]
    pub output: Option<OutputArg>,
    /// Compare the events with those in a file (or in a recording); 1 if they differ
    #[arg(long, value_name = "FILE", conflicts_with = "update")]
    pub expect: Option<PathBuf>,
    /// Times may differ by so much, ms
    #[arg(long, value_name = "T", requires = "expect", default_value_t = 0.0, value_parser = seconds)]
    pub tolerance_ms: f64,
    /// Save the events as what is expected
    #[arg(long, value_name = "FILE")]
    pub update: Option<PathBuf>,
    /// Tell nothing before this time, s, as events print it; what came before is played all the same
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub from: Option<f64>,
    /// End at this time, s
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub to: Option<f64>,
    /// At the pace at which it was played, not as fast as it goes
    #[arg(long)]
    pub realtime: bool,
    /// The verdict as JUnit XML
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

#[derive(Args, Debug)]
#[command(after_help = "Example: gelpad recover cut.mcap -o saved.mcap

Ends 0 if nothing was lost, 3 if something was: what, is said.")]
pub(super) struct RecoverArgs {
    /// A recording that is cut or damaged
    pub file: PathBuf,
    /// Where what it holds goes, packed
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad export session.mcap --format fm2 -o session.fm2    fceux --playmov session.fm2 game.nes
  gelpad export session.mcap --format csv -o frames.csv     which replay, studies and spreadsheets read
  gelpad export session.mcap --format evemu -o session.evemu")]
pub(super) struct ExportArgs {
    /// A recording
    pub file: PathBuf,
    /// What to make of it
    #[arg(long, value_enum)]
    pub format: ExportFormat,
    /// Where it goes
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// fm2: the frame of the movie, counted from power-on, in which the session begins
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u64).range(0..=5_000_000))]
    pub start_frame: u64,
    /// fm2: the game's name, for FCEUX to show
    #[arg(long, value_name = "NAME", default_value = "game")]
    pub rom: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum ExportFormat {
    /// A movie of FCEUX: the buttons of the NES pad in each frame
    Fm2,
    /// Events as evemu-record writes them
    Evemu,
    /// Frames: t_ms,v0,v1,...
    Csv,
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

/// What `--source` says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum SourceArg {
    /// The simulated pad with a script, or with the level.
    Simulated(Option<PathBuf>),
    /// A board.
    Serial(String),
    /// A file, in real time.
    Replay(PathBuf),
    /// Gamepads and switches.
    Gamepad,
}

impl std::str::FromStr for SourceArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, rest) = match text.split_once(':') {
            Some((kind, rest)) => (kind, Some(rest).filter(|rest| !rest.is_empty())),
            None => (text, None),
        };
        match (kind, rest) {
            ("simulated", script) => Ok(Self::Simulated(script.map(PathBuf::from))),
            ("serial", Some(port)) => Ok(Self::Serial(port.to_owned())),
            ("replay", Some(file)) => Ok(Self::Replay(PathBuf::from(file))),
            ("gamepad", None) => Ok(Self::Gamepad),
            ("serial", None) => Err("which port? as in serial:/dev/ttyACM0".to_owned()),
            ("replay", None) => Err("which file? as in replay:frames.csv".to_owned()),
            _ => Err(
                "write simulated, simulated:SCRIPT, serial:PORT, replay:FILE or gamepad".to_owned(),
            ),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum OutputArg {
    /// The best there is, and one line that says why; with the simulated pad: trace
    Auto,
    /// Keys and mouse of this desktop; of the kernel where there is no display
    Keyboard,
    /// An Xbox 360 pad, a keyboard and a mouse of the Linux kernel (uinput)
    Gamepad,
    /// Events as text on stdout
    Trace,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum PrintArg {
    Touches,
    Events,
}

fn seconds(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|number| (0.0..1e9).contains(number))
        .ok_or_else(|| "a number, 0 or more".to_owned())
}

fn points(text: &str) -> Result<usize, String> {
    let range =
        crate::calibrate::FEWEST_PRESSES..=crate::touch::correction::MOST_CORRECTION_PRESSES;
    text.parse::<usize>()
        .ok()
        .filter(|points| range.contains(points))
        .ok_or_else(|| format!("a number of places, {} to {}", range.start(), range.end()))
}

fn above_zero(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|number| *number > 0.0 && *number <= 1e6)
        .ok_or_else(|| "a number above 0".to_owned())
}

fn rate(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|rate| *rate == 0.0 || (0.01..=1e5).contains(rate))
        .ok_or_else(|| "frames a second, 0.01 to 100000, or 0".to_owned())
}

fn percent(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|percent| (0.0..=100.0).contains(percent))
        .ok_or_else(|| "a percentage, 0 to 100".to_owned())
}

fn snr(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|db| (0.0..=300.0).contains(db))
        .ok_or_else(|| "a ratio in dB, 0 to 300".to_owned())
}
