//! The arguments as given. Names are a contract: other people's scripts use them.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::study::Vary;
use crate::study::job::Shard;
use crate::study::thickness::Parameters;
use crate::study::width::Rank;
use crate::types::Method;

/// Play games on a soft sheet of hydrogel.
///
/// Without a command it plays a scripted level on the simulated pad and shows it here; nothing is sent to your
/// desktop.
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
    /// Turn recorded frames into touches or events, as fast as it goes
    Replay(ReplayArgs),
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
    /// Whether the thickness of the conducting layer matters: presses and currents in three dimensions
    #[command(after_help = "\
Examples:
  gelpad study thickness --out thickness --quick       one coarse case of each kind
  gelpad study thickness --out thickness               an hour or so on two cores; says first what it takes
  gelpad study thickness --out stiff --silicone-kpa 300 --layers 1,3")]
    Thickness {
        #[command(flatten)]
        common: StudyArgs,
        #[command(flatten)]
        parameters: ThicknessArgs,
        /// One coarse case of each kind
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

/// What the paper does not say of the sensor and its presses.
#[derive(Args, Debug)]
pub(super) struct ThicknessArgs {
    /// Thicknesses of the conducting layer
    #[arg(
        long,
        value_name = "MM,...",
        value_delimiter = ',',
        default_value = "1,2,3,4,5"
    )]
    layers: Vec<f64>,
    /// How deep the indenter is pressed
    #[arg(
        long,
        value_name = "MM,...",
        value_delimiter = ',',
        default_value = "2,5"
    )]
    depths: Vec<f64>,
    /// How deep it is pressed on a rigid table, as shares of the sensor's thickness
    #[arg(
        long,
        value_name = "SHARE,...",
        value_delimiter = ',',
        default_value = "0.25,0.5"
    )]
    table_shares: Vec<f64>,
    /// Radius of the flat indenter and of the local rise
    #[arg(long, value_name = "MM", default_value_t = 5.0)]
    indenter_mm: f64,
    /// Silicone below and above the layer
    #[arg(long, value_name = "MM", default_value_t = 1.0)]
    cover_mm: f64,
    /// Young's modulus of the silicone (Ecoflex 00-30: 69 kPa at 100 % strain)
    #[arg(long, value_name = "KPA", default_value_t = 118.0)]
    silicone_kpa: f64,
    /// Young's modulus of the hydrogel
    #[arg(long, value_name = "KPA", default_value_t = 20.0)]
    hydrogel_kpa: f64,
    /// Poisson's ratio of both
    #[arg(long, value_name = "RATIO", default_value_t = 0.4999)]
    poisson: f64,
    /// Young's modulus of the soft foundation
    #[arg(long, value_name = "KPA", default_value_t = 20.0)]
    foundation_kpa: f64,
    /// Thickness of the soft foundation
    #[arg(long, value_name = "MM", default_value_t = 20.0)]
    foundation_mm: f64,
    /// Conductivity of the local rise, S/m
    #[arg(long, value_name = "S_PER_M", default_value_t = 5.0)]
    rise: f64,
}

impl From<&ThicknessArgs> for Parameters {
    fn from(args: &ThicknessArgs) -> Self {
        Self {
            layers_mm: args.layers.clone(),
            cover_mm: args.cover_mm,
            depths_mm: args.depths.clone(),
            table_shares: args.table_shares.clone(),
            indenter_mm: args.indenter_mm,
            silicone_kpa: args.silicone_kpa,
            hydrogel_kpa: args.hydrogel_kpa,
            poisson: args.poisson,
            foundation_kpa: args.foundation_kpa,
            foundation_mm: args.foundation_mm,
            rise_s_per_m: args.rise,
            ..Self::default()
        }
    }
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

A board's frame, for serial:PORT (115200 baud, OpenEIT's text, a comma behind every value):
  magnitudes:        1.5000,       2.0000, ... ,\\r\\n")]
pub(super) struct PlayArgs {
    /// A shipped profile, or a file (an argument with a `/` or ending in `.toml`)
    #[arg(default_value = crate::profile::DEFAULT_PROFILE)]
    pub profile: String,
    /// One person's settings over the profile: a name (users/NAME.toml here, among your own, or shipped) or a file
    #[arg(long, value_name = "NAME")]
    pub user: Option<String>,
    /// Play another profile while the program that its `[match]` names runs (Linux)
    #[arg(long = "match")]
    pub follow: bool,
    /// A shipped pad, or a file
    #[arg(long, default_value = crate::pad::DEFAULT_PAD)]
    pub pad: String,
    /// Where frames come from: `simulated[:SCRIPT]`, `serial:PORT` or `replay:FILE`
    #[arg(long, default_value = "simulated")]
    pub source: SourceArg,
    /// Where events go; auto: the keyboard where there is a display, else (and for the simulated pad) the trace
    #[arg(long, value_enum, default_value_t = OutputArg::Auto)]
    pub output: OutputArg,
    /// What a board sends
    #[arg(long, value_enum, default_value_t = FormatArg::Auto)]
    pub format: FormatArg,
    /// How images are made: tikhonov, noser, smooth or l1 [default: what profile or pad say, else noser]
    #[arg(long)]
    pub method: Option<Method>,
    /// What `gelpad calibrate` saved: places and force as presses have shown them
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
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
#[command(after_help = "Example: gelpad replay frames.csv --pad edinburgh-lattice --print touches")]
pub(super) struct ReplayArgs {
    /// Frames as CSV: t_ms,v0,v1,...
    pub file: PathBuf,
    /// A shipped pad, or a file (an argument with a `/` or ending in `.toml`)
    #[arg(long, default_value = crate::pad::DEFAULT_PAD)]
    pub pad: String,
    /// A shipped profile, or a file
    #[arg(long, default_value = crate::profile::DEFAULT_PROFILE)]
    pub profile: String,
    /// One person's settings over the profile
    #[arg(long, value_name = "NAME")]
    pub user: Option<String>,
    /// How images are made: tikhonov, noser, smooth or l1 [default: what profile or pad say, else noser]
    #[arg(long)]
    pub method: Option<Method>,
    /// What `gelpad calibrate` saved: places and force as presses have shown them
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
    /// touches: a JSON line a frame; events: a text line an event
    #[arg(long, value_enum, default_value_t = PrintArg::Events)]
    pub print: PrintArg,
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
    /// How images are made while recording: tikhonov, noser, smooth or l1 [default: what the pad says, else noser]
    #[arg(long)]
    pub method: Option<Method>,
    /// Signal-to-noise ratio of the simulated pad, dB
    #[arg(long, value_name = "DB", default_value_t = 60.0, value_parser = snr)]
    pub snr: f64,
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
            ("serial", None) => Err("which port? as in serial:/dev/ttyACM0".to_owned()),
            ("replay", None) => Err("which file? as in replay:frames.csv".to_owned()),
            _ => Err("write simulated, simulated:SCRIPT, serial:PORT or replay:FILE".to_owned()),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum OutputArg {
    Auto,
    Keyboard,
    Trace,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum FormatArg {
    /// The one format there is: OpenEIT's text
    Auto,
    Openeit,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum PrintArg {
    Touches,
    Events,
}

fn points(text: &str) -> Result<usize, String> {
    let range =
        crate::calibrate::FEWEST_PRESSES..=crate::touch::correction::MOST_CORRECTION_PRESSES;
    text.parse::<usize>()
        .ok()
        .filter(|points| range.contains(points))
        .ok_or_else(|| format!("a number of places, {} to {}", range.start(), range.end()))
}

fn snr(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|db| (0.0..=300.0).contains(db))
        .ok_or_else(|| "a ratio in dB, 0 to 300".to_owned())
}
