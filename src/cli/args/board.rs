//! What `gelpad listen` and `gelpad device` take, and how a board is read.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::values::{above_zero, percent, rate, snr};
use crate::cli::device::{Between, Loose};
use crate::source::board::Every;
use crate::source::serial::DEFAULT_BAUD;
use crate::source::wire::Format;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad listen /dev/ttyACM0                   ten seconds; a board that says nothing is sent the known start commands
  gelpad listen /dev/ttyUSB0 --mute --seconds 60 --format lines")]
pub(in crate::cli) struct ListenArgs {
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
pub(in crate::cli) struct DeviceArgs {
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
pub(in crate::cli) enum LayoutArg {
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
pub(in crate::cli) struct BoardArgs {
    /// What a board sends: auto, openeit, square, request, lines, lines:complex, sciospec or gelpad
    #[arg(long, value_name = "F", default_value = "auto")]
    pub format: Format,
    /// Speed of a serial port (USB boards take any)
    #[arg(long, value_name = "BAUD", default_value_t = DEFAULT_BAUD)]
    pub baud: u32,
}
