//! Arguments of `gelpad pad` and `gelpad profile`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::board::BoardArgs;
use super::values::{points, snr, source};
use crate::app::services::SourceChoice;

#[derive(Debug, Subcommand)]
#[command(after_help = "Example: gelpad pad check ./my-pad.toml")]
pub(in crate::cli) enum PadCommand {
    /// List the pads: shipped and your own
    #[command(after_help = "Example: gelpad pad list")]
    List,
    /// Check a pad's text, and whether the pad gives an image
    #[command(after_help = "Example: gelpad pad check ./my-pad.toml")]
    Check {
        /// A shipped pad, or a file
        #[arg(default_value = crate::pad::DEFAULT_PAD)]
        pad: String,
    },
    /// Show a pad: drawing and dimensions; --toml prints its text, to copy and edit
    #[command(after_help = "Example: gelpad pad show edinburgh-lattice --toml > my-pad.toml")]
    Show {
        /// A shipped pad, or a file
        #[arg(default_value = crate::pad::DEFAULT_PAD)]
        pad: String,
        /// Print its text
        #[arg(long)]
        toml: bool,
    },
    /// Find how the connected pad differs from its drawing, from a second of untouched frames and, if you like, presses
    #[command(after_help = "\
Examples:
  gelpad pad identify --source serial:/dev/ttyACM0 -o my-pad.toml
    then: gelpad play --pad ./my-pad.toml
  gelpad pad identify --source serial:/dev/ttyACM0 --points 30 -o my-pad.toml
    asks for presses, too: they tell more of the pad
  gelpad pad identify ./my-pad.toml --source replay:untouched.csv --map found.png
  gelpad pad identify
    the simulated pad differs by its mesh only

`gelpad play` does this on boards while you play; the command shows what was found.

The pad must not be touched, but with --points where a place is shown. Nothing is written if no pad like the drawing explains the readings.")]
    Identify(IdentifyArgs),
}

#[derive(Args, Debug)]
pub(in crate::cli) struct IdentifyArgs {
    /// The pad's drawing: a shipped pad, or a file (contains `/` or ends in `.toml`)
    #[arg(default_value = crate::pad::DEFAULT_PAD)]
    pub pad: String,
    /// Where frames come from: `serial:PORT`, `replay:FILE` or `simulated[:SCRIPT]`
    #[arg(long, default_value = "simulated", value_parser = source)]
    pub source: SourceChoice,
    /// Presses of this pad, as `gelpad calibrate --presses FILE` records them: they tell what the untouched pad leaves open. With
    /// --points, the file for the recorded presses
    #[arg(long, value_name = "FILE.csv")]
    pub presses: Option<PathBuf>,
    /// Show this many places, to be pressed one after the other (simulated: a robot presses)
    #[arg(long, value_name = "N", value_parser = points)]
    pub points: Option<usize>,
    /// File for the pad as found
    #[arg(short, long, value_name = "FILE.toml")]
    pub output: Option<PathBuf>,
    /// Draw the conductance that was found, as PNG or SVG
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Untouched frames to read
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(5..=10_000))]
    pub frames: u32,
    /// Signal-to-noise ratio of the simulated pad, dB
    #[arg(long, value_name = "DB", default_value_t = 60.0, value_parser = snr)]
    pub snr: f64,
    /// Seed of the simulated noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    #[command(flatten)]
    pub board: BoardArgs,
}

#[derive(Debug, Subcommand)]
#[command(after_help = "Example: gelpad profile check ./mine.toml")]
pub(in crate::cli) enum ProfileCommand {
    /// List the profiles and user settings: shipped and your own
    #[command(after_help = "Example: gelpad profile list")]
    List,
    /// Check a profile: errors and warnings
    #[command(after_help = "Example: gelpad profile check ./mine.toml --user anna")]
    Check {
        /// A shipped profile, or a file
        #[arg(default_value = crate::profile::DEFAULT_PROFILE)]
        profile: String,
        /// Apply the settings of one user
        #[arg(long, value_name = "NAME")]
        user: Option<String>,
    },
    /// Print the JSON schema of profiles, for editors
    #[command(after_help = "Example: gelpad profile schema > profile.schema.json")]
    Schema,
    /// Show a profile: map, bindings, and where each value comes from
    #[command(after_help = "\
Examples:
  gelpad profile show super-mario --toml > mine.toml      prints its text, to copy and edit
  gelpad profile show ./mine.toml --print regions.svg     draws a sheet to print, cut out and lay on the pad")]
    Show(ShowArgs),
}

#[derive(Args, Debug)]
pub(in crate::cli) struct ShowArgs {
    /// A shipped profile, or a file
    #[arg(default_value = crate::profile::DEFAULT_PROFILE)]
    pub profile: String,
    /// Apply the settings of one user
    #[arg(long, value_name = "NAME")]
    pub user: Option<String>,
    /// Print its text
    #[arg(long, conflicts_with_all = ["svg", "png", "print"])]
    pub toml: bool,
    /// Draw the regions as SVG
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Draw the regions as PNG
    #[arg(long, value_name = "FILE")]
    pub png: Option<PathBuf>,
    /// Draw the regions as SVG at true scale on an A4 sheet, with a ruler
    #[arg(long, value_name = "FILE")]
    pub print: Option<PathBuf>,
    /// The pad that gives the drawings their size
    #[arg(long, default_value = crate::pad::DEFAULT_PAD)]
    pub pad: String,
}
