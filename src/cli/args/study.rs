//! What `gelpad study` and `gelpad accuracy` take.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::values::snr;
use crate::study::Vary;
use crate::study::job::Shard;
use crate::study::thickness::Parameters;
use crate::study::width::Rank;
use crate::types::Method;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad accuracy --out accuracy                                  about a minute on two cores
  gelpad accuracy --pad ./my-pad.toml --snr 70,60,45 --out mine
  gelpad accuracy --pad round-tank --quick --out tank             some ten seconds: whether all works, not how well")]
pub(in crate::cli) struct AccuracyArgs {
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
pub(in crate::cli) enum StudyCommand {
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
  gelpad study thickness --out thickness               half an hour or so on two cores; says first what it takes
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
pub(in crate::cli) struct StudyArgs {
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
pub(in crate::cli) struct ThicknessArgs {
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
pub(in crate::cli) enum RankArg {
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
