//! Arguments of `gelpad study` and `gelpad accuracy`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::values::snr;
use crate::source::Disturbance;
use crate::study::ParameterSweep;
use crate::study::job::Shard;
use crate::study::thickness::ThicknessParameters;
use crate::study::width::RankCriterion;
use crate::types::Method;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad accuracy --out accuracy                                  some seven minutes on two cores
  gelpad accuracy --as-drawn --out drawn                          pads are not identified: a minute
  gelpad accuracy --pad ./my-pad.toml --snr 70,60,45 --out mine
  gelpad accuracy --real --out real                               ADC steps, spikes, edges: some minutes
  gelpad accuracy --pad round-tank --quick --out tank             a quick test in seconds, not for results")]
pub(in crate::cli) struct AccuracyArgs {
    /// Folder for report, figure, JSON and CSV
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// A shipped pad, or a file (contains `/` or ends in `.toml`)
    #[arg(long, default_value = crate::pad::DEFAULT_PAD)]
    pub pad: String,
    /// Signal-to-noise ratios, dB
    #[arg(long, value_name = "DB,...", value_delimiter = ',', value_parser = snr, default_value = "80,60,50,40")]
    pub snr: Vec<f64>,
    /// Reconstruction: tikhonov, noser, smooth or l1 [default: the pad's, else noser]
    #[arg(long)]
    pub method: Option<Method>,
    /// Seed of specimens, touches and noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Few random draws: a quick test, not for results
    #[arg(long)]
    pub quick: bool,
    /// Locate touches with the pad as drawn, not with the pad as play identifies it from its readings at rest: faster
    #[arg(long, conflicts_with_all = ["real", "scan"])]
    pub as_drawn: bool,
    /// Play the conditions of real boards, pads and hands, and print what is missed, false and off
    #[arg(long)]
    pub real: bool,
    /// With --real: pads that differ from their drawing, with the drawing and with the pad as found from its readings at rest
    #[arg(long, requires = "real", conflicts_with_all = ["only", "disturb"])]
    pub identify: bool,
    /// Play presses on a pad whose drives are read one after another, frame by frame and part by part
    #[arg(long, conflicts_with = "real")]
    pub scan: bool,
    /// With --real: only conditions whose name contains TEXT
    #[arg(long, value_name = "TEXT", default_value = "", requires = "real")]
    pub only: String,
    /// With --real: one condition of your own, such as adc:12,gain:60. Names: adc:BITS, saturated:SHARE, gain:DB, drive:DB,
    /// flicker:DB, noisy-channel:SHARE, dead-channel, mains:SHARE, spikes:SIGMA, surge:SHARE, bad-start:FACTOR, garbage-start,
    /// bad-frame:FACTOR, repeated-start:FRAMES, gain-step:SHARE, lost-pair, stuck-frame, unplugged:SECONDS, turned:PLACES,
    /// mirrored:PLACES
    #[arg(
        long,
        value_name = "NAME[:VALUE],...",
        value_delimiter = ',',
        requires = "real"
    )]
    pub disturb: Vec<Disturbance>,
}

#[derive(Debug, Subcommand)]
#[command(after_help = "Example: gelpad study width --out width-study")]
pub(in crate::cli) enum StudyCommand {
    /// How the signal depends on the width of the channels, or on another number in the pad's text
    #[command(after_help = "\
Examples:
  gelpad study width --out width-study
  gelpad study width --out pitch --vary lattice.x_lines=7..15:2 --rank bound
  gelpad study width --out part3 --shard 3/8      (a job array; then: gelpad study merge part* --out whole)")]
    Width {
        #[command(flatten)]
        common: StudyArgs,
        /// Vary another number of the pad's text: PARAMETER=FROM..TO:STEP, such as lattice.width=1..5:0.5
        #[arg(long, value_name = "P=A..B:STEP")]
        vary: Option<ParameterSweep>,
        /// Measure that ranks the variants
        #[arg(long, value_enum, default_value_t = RankArg::Bound)]
        rank: RankArg,
        /// Use fewer places
        #[arg(long)]
        quick: bool,
        /// Seed of the random places
        #[arg(long, value_name = "N", default_value_t = 1)]
        seed: u64,
    },
    /// Images of five phantoms, reconstructed by Tikhonov and L1
    #[command(after_help = "Example: gelpad study phantoms --out phantoms")]
    Phantoms {
        #[command(flatten)]
        common: StudyArgs,
        /// Only one point and the annulus
        #[arg(long)]
        quick: bool,
        /// Seed of the noise
        #[arg(long, value_name = "N", default_value_t = 1)]
        seed: u64,
    },
    /// Whether the thickness of the conducting layer matters: presses and currents in 3D
    #[command(after_help = "\
Examples:
  gelpad study thickness --out thickness --quick       one coarse case of each kind
  gelpad study thickness --out thickness               half an hour on two cores; prints an estimate first
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
    /// In which order to read the drives, and which readings to leave out
    #[command(after_help = "\
Examples:
  gelpad study protocol --out protocol                            the best order, and what 0.3 mm at 60 dB needs
  gelpad study protocol --out fast --snr 70 --keep 0.5 --pad ./my-pad.toml
  gelpad accuracy --scan --pad protocol/pad-order.toml --out scan   (how soon presses are then seen)")]
    Protocol {
        #[command(flatten)]
        common: StudyArgs,
        /// Signal-to-noise ratio of each reading, dB
        #[arg(long, value_name = "DB", value_parser = snr, default_value_t = 60.0)]
        snr: f64,
        /// Mean error of place that the fewest readings keep, mm
        #[arg(long, value_name = "MM", default_value_t = 0.3)]
        keep: f64,
        /// Fewer fingers
        #[arg(long)]
        quick: bool,
        /// Seed of the fingers
        #[arg(long, value_name = "N", default_value_t = 1)]
        seed: u64,
    },
    /// Merge the folders of all shards
    #[command(after_help = "Example: gelpad study merge part1 part2 --out whole")]
    Merge {
        /// Folders of the shards
        #[arg(required = true)]
        folders: Vec<PathBuf>,
        /// Folder for the merged study
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
}

/// Arguments of every study.
#[derive(Args, Debug)]
pub(in crate::cli) struct StudyArgs {
    /// Folder for the report; an interrupted study continues from it
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// A shipped pad, or a file (contains `/` or ends in `.toml`)
    #[arg(long, default_value = crate::pad::DEFAULT_PAD)]
    pub pad: String,
    /// Solve the K-th of N parts of the cases only
    #[arg(
        long,
        value_name = "K/N",
        default_value = "1/1",
        hide_default_value = true
    )]
    pub shard: Shard,
}

/// Parameters of the sensor and its presses that the paper does not give.
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
    /// Indentation depths
    #[arg(
        long,
        value_name = "MM,...",
        value_delimiter = ',',
        default_value = "2,5"
    )]
    depths: Vec<f64>,
    /// Indentation depths on a rigid table, as fractions of the sensor's thickness
    #[arg(
        long,
        value_name = "SHARE,...",
        value_delimiter = ',',
        default_value = "0.25,0.5"
    )]
    table_shares: Vec<f64>,
    /// Radius of the flat indenter and of the local conductivity change
    #[arg(long, value_name = "MM", default_value_t = 5.0)]
    indenter_mm: f64,
    /// Thickness of the silicone below and above the layer
    #[arg(long, value_name = "MM", default_value_t = 1.0)]
    cover_mm: f64,
    /// Young's modulus of the silicone (Ecoflex 00-30: 69 kPa at 100 % strain)
    #[arg(long, value_name = "KPA", default_value_t = 118.0)]
    silicone_kpa: f64,
    /// Young's modulus of the hydrogel
    #[arg(long, value_name = "KPA", default_value_t = 20.0)]
    hydrogel_kpa: f64,
    /// Poisson's ratio of silicone and hydrogel
    #[arg(long, value_name = "RATIO", default_value_t = 0.4999)]
    poisson: f64,
    /// Young's modulus of the soft foundation
    #[arg(long, value_name = "KPA", default_value_t = 20.0)]
    foundation_kpa: f64,
    /// Thickness of the soft foundation
    #[arg(long, value_name = "MM", default_value_t = 20.0)]
    foundation_mm: f64,
    /// Conductivity where pressed, S/m
    #[arg(long, value_name = "S_PER_M", default_value_t = 5.0)]
    rise: f64,
}

impl From<&ThicknessArgs> for ThicknessParameters {
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
    /// Cramer-Rao bound of a touch's place
    Bound,
}

impl From<RankArg> for RankCriterion {
    fn from(arg: RankArg) -> Self {
        match arg {
            RankArg::Change => Self::Change,
            RankArg::Relative => Self::Relative,
            RankArg::Bound => Self::Bound,
        }
    }
}
