//! What `gelpad replay`, `recover` and `export` take.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::values::{OutputArg, PrintArg, seconds};
use crate::types::Method;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad replay session.mcap                                    its events, as they were played
  gelpad replay session.mcap --update session.events            save them as what is expected ...
  gelpad replay session.mcap --expect session.events            ... and see whether they still come
  gelpad replay session.mcap --profile ./mine.toml --print events
  gelpad replay session.mcap --realtime --output keyboard --from 12 --to 20
  gelpad replay frames.csv --pad edinburgh-lattice --print touches")]
pub(in crate::cli) struct ReplayArgs {
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
pub(in crate::cli) struct RecoverArgs {
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
pub(in crate::cli) struct ExportArgs {
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
pub(in crate::cli) enum ExportFormat {
    /// A movie of FCEUX: the buttons of the NES pad in each frame
    Fm2,
    /// Events as evemu-record writes them
    Evemu,
    /// Frames: t_ms,v0,v1,...
    Csv,
}
