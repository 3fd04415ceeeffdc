//! Arguments of `gelpad replay`, `recover` and `export`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::values::{OutputArg, PrintArg, seconds};
use crate::types::Method;

#[derive(Args, Clone, Debug)]
#[command(after_help = "\
Examples:
  gelpad replay session.mcap                                    prints the events as they were played
  gelpad replay session.mcap --update session.events            saves them as the expected events
  gelpad replay session.mcap --expect session.events            compares with the expected events
  gelpad replay session.mcap --profile ./mine.toml --print events
  gelpad replay session.mcap --realtime --output keyboard --from 12 --to 20
  gelpad replay frames.csv --pad edinburgh-lattice --print touches")]
pub(in crate::cli) struct ReplayArgs {
    /// A recording (.mcap), frames as CSV (t_ms,v0,v1,...), a folder of Sciospec .eit files, or a table with one frame per column
    pub file: PathBuf,
    /// A shipped pad, or a file (contains `/` or ends in `.toml`) [default: the recording's own; edinburgh-lattice for CSV]
    #[arg(long)]
    pub pad: Option<String>,
    /// A shipped profile, or a file [default: the recording's own; super-mario for CSV]
    #[arg(long)]
    pub profile: Option<String>,
    /// Settings of one user, applied over the profile
    #[arg(long, value_name = "NAME")]
    pub user: Option<String>,
    /// Reconstruction: tikhonov, noser, smooth or l1 [default: as recorded; for CSV the profile's or the pad's, else noser]
    #[arg(long)]
    pub method: Option<Method>,
    /// A calibration or learned pad (FILE.toml) from `gelpad calibrate` [default: the recording's own]
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
    /// touches: a JSON line per frame; events: a text line per event [default: events, unless sent, compared or saved]
    #[arg(long, value_enum)]
    pub print: Option<PrintArg>,
    /// Send the events to an output
    #[arg(long, value_enum)]
    pub output: Option<OutputArg>,
    /// Compare the events with a file or a recording; exit code 1 if they differ
    #[arg(long, value_name = "FILE", conflicts_with = "update")]
    pub expect: Option<PathBuf>,
    /// Tolerated difference of times, ms
    #[arg(long, value_name = "T", requires = "expect", default_value_t = 0.0, value_parser = seconds)]
    pub tolerance_ms: f64,
    /// Save the events as the expected events
    #[arg(long, value_name = "FILE")]
    pub update: Option<PathBuf>,
    /// Print nothing before this time of the events, s; earlier frames are still played
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub from: Option<f64>,
    /// End at this time, s
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub to: Option<f64>,
    /// Frames from a file were read drive by drive, over the time that ends at their t_ms: touches are looked for part by part
    #[arg(long)]
    pub scan: bool,
    /// Replay in real time instead of as fast as possible
    #[arg(long)]
    pub realtime: bool,
    /// Write the result as JUnit XML
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

#[derive(Args, Debug)]
#[command(after_help = "Example: gelpad recover cut.mcap -o saved.mcap

The exit code is 0 if nothing was lost, 3 if something was; messages say what.")]
pub(in crate::cli) struct RecoverArgs {
    /// A truncated or damaged recording
    pub file: PathBuf,
    /// File for the saved part, compressed
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Pad of a recording whose own pad cannot be read, ignored otherwise: a shipped name or ./PATH [default: edinburgh-lattice]
    #[arg(long, value_name = "PAD")]
    pub pad: Option<String>,
}

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad export session.mcap --format fm2 -o session.fm2    fceux --playmov session.fm2 game.nes
  gelpad export session.mcap --format csv -o frames.csv     for replay, studies and spreadsheets
  gelpad export session.mcap --format evemu -o session.evemu")]
pub(in crate::cli) struct ExportArgs {
    /// A recording
    pub file: PathBuf,
    /// The format to write
    #[arg(long, value_enum)]
    pub format: ExportFormat,
    /// The file to write
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// fm2: the frame of the movie, counted from power-on, at which the session starts
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u64).range(0..=5_000_000))]
    pub start_frame: u64,
    /// fm2: name of the game, as FCEUX shows it
    #[arg(long, value_name = "NAME", default_value = "game")]
    pub rom: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum ExportFormat {
    /// FCEUX movie: the buttons of the NES controller in each frame
    Fm2,
    /// Events in the format of evemu-record
    Evemu,
    /// Frames: t_ms,v0,v1,...
    Csv,
}
