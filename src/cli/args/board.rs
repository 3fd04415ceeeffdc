//! Arguments of `gelpad listen` and `gelpad device`, and of boards.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::values::{above_zero, percent, rate, snr};
use crate::app::services::BoardLine;
use crate::source::board::RepeatedFault;
use crate::source::serial::DEFAULT_BAUD;
use crate::source::wire::FormatChoice;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad listen /dev/ttyACM0                   listens for 10 s; sends the known start commands to a silent board
  gelpad listen /dev/ttyUSB0 --mute --seconds 60 --format lines")]
pub(in crate::cli) struct ListenArgs {
    /// Serial port of the board
    pub port: String,
    /// Time to listen, s
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = above_zero)]
    pub seconds: f64,
    /// End after N frames
    #[arg(long, value_name = "N")]
    pub frames: Option<u64>,
    /// Send nothing to the board
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
  gelpad device --port ./board --format gelpad --rate 500 --lose-bytes 0.01 --flip-bits 0.001
  gelpad device --port ./board --format openeit --pad openeit-lattice --baud 115200 --rate 0
  gelpad device --port ./board --format lines:rotated --pause 5,800 --hang-up 20,1500 --lose-electrode 5@10

The board reads the simulated pad, pressed by a touch script (default: the level) that repeats.")]
pub(in crate::cli) struct DeviceArgs {
    /// Create a link to the port at this path [default: the path that the system assigns, which is printed]
    #[arg(long, value_name = "PATH")]
    pub port: Option<PathBuf>,
    /// Wire format: openeit, square, request, lines, lines:complex, sciospec or gelpad; with :rotated or :flipped
    #[arg(long, value_name = "F")]
    pub format: FormatChoice,
    /// The pad that the board reads: a shipped one, or a file
    #[arg(long, default_value = crate::pad::DEFAULT_PAD)]
    pub pad: String,
    /// Touch script that presses the pad
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// Frames per second; 0: as fast as the host reads
    #[arg(long, value_name = "HZ", default_value_t = 100.0, value_parser = rate)]
    pub rate: f64,
    /// End after N frames
    #[arg(long, value_name = "N")]
    pub frames: Option<u64>,
    /// Readings of a frame [default: the pad's; square: all pairs]
    #[arg(long, value_enum)]
    pub layout: Option<LayoutArg>,
    /// Send integer counts of a converter instead of volts (gelpad)
    #[arg(long)]
    pub counts: bool,
    /// Send the readings of each drive as a packet of their own (gelpad)
    #[arg(long)]
    pub by_drive: bool,
    /// Read each frame at one moment, instead of one drive after another
    #[arg(long)]
    pub moments: bool,
    /// Speed of the serial line, baud: bytes take their time [default: as fast as USB]
    #[arg(long, value_name = "BAUD", value_parser = clap::value_parser!(u32).range(300..))]
    pub baud: Option<u32>,
    /// Print no menu at reset (openeit)
    #[arg(long)]
    pub no_menu: bool,
    /// Signal-to-noise ratio of the pad, dB
    #[arg(long, value_name = "DB", default_value_t = 60.0, value_parser = snr)]
    pub snr: f64,
    /// Drift of all voltages, % per minute
    #[arg(
        long,
        value_name = "PERCENT",
        default_value_t = 0.0,
        allow_hyphen_values = true
    )]
    pub drift: f64,
    /// Electrode (1 to N) that loses contact, and the second at which it does
    #[arg(long, value_name = "N[@S]")]
    pub lose_electrode: Option<LostElectrodeArg>,
    /// Lost bytes, %
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0, value_parser = percent)]
    pub lose_bytes: f64,
    /// Flipped bits, %
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0, value_parser = percent)]
    pub flip_bits: f64,
    /// Frames that are cut in half, %
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0, value_parser = percent)]
    pub half_frames: f64,
    /// Every S seconds, send no frames for MS milliseconds
    #[arg(long, value_name = "S,MS")]
    pub pause: Option<RepeatedFault>,
    /// Every S seconds, close the port for MS milliseconds
    #[arg(long, value_name = "S,MS")]
    pub hang_up: Option<RepeatedFault>,
    /// Every S seconds, send format F for MS milliseconds
    #[arg(long, value_name = "F,S,MS")]
    pub between: Option<FormatInterval>,
    /// Seed of noise and faults
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum LayoutArg {
    /// n (n - 3) adjacent readings
    Full,
    /// the half of these that is independent by reciprocity
    Half,
    /// all n x n pairs, zeros at the driven ones
    Square,
    /// opposite drive, n (n - 4)
    Opposite,
}

/// Format and speed of a board on a serial port.
#[derive(Args, Clone, Debug)]
pub(in crate::cli) struct BoardArgs {
    /// Wire format of the board: auto, openeit, square, request, lines, lines:complex, sciospec or gelpad
    #[arg(long, value_name = "F", default_value = "auto")]
    pub format: FormatChoice,
    /// Speed of the serial port (USB boards accept any)
    #[arg(long, value_name = "BAUD", default_value_t = DEFAULT_BAUD)]
    pub baud: u32,
}

impl BoardArgs {
    /// Format and speed for a request.
    pub(in crate::cli) fn line(&self) -> BoardLine {
        BoardLine {
            format: self.format,
            baud: self.baud,
        }
    }
}

/// `FORMAT,S,MS`.
#[derive(Clone, Debug)]
pub(in crate::cli) struct FormatInterval {
    pub format: FormatChoice,
    pub every: RepeatedFault,
}

impl std::str::FromStr for FormatInterval {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (format, every) = text
            .split_once(',')
            .ok_or("expected a format, a period and a duration, such as openeit,5,500")?;
        Ok(Self {
            format: format.parse()?,
            every: every.parse()?,
        })
    }
}

/// `N[@S]`, the electrode counted from 1.
#[derive(Clone, Copy, Debug)]
pub(in crate::cli) struct LostElectrodeArg {
    pub number: usize,
    pub from_s: f64,
}

impl std::str::FromStr for LostElectrodeArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, from_s) = text.split_once('@').unwrap_or((text, "0"));
        match (number.parse(), from_s.parse::<f64>()) {
            (Ok(number), Ok(from_s)) if number > 0 && (0.0..1e6).contains(&from_s) => {
                Ok(Self { number, from_s })
            }
            _ => Err("expected an electrode (from 1) and a time in s, such as 5@10".to_owned()),
        }
    }
}
