//! What `gelpad study` and `gelpad accuracy` take.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::values::snr;
use crate::study::Vary;
use crate::study::job::Shard;
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
