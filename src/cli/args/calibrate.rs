//! Arguments of `gelpad calibrate`.

use std::path::PathBuf;

use clap::Args;

use super::board::BoardArgs;
use super::values::{points, size_mm, snr, source};
use crate::app::services::{NoiseLevel, SourceChoice};
use crate::cli::guided_presses::PressSource;
use crate::types::Method;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad calibrate --source serial:/dev/ttyACM0 --points 50 --presses mine.csv
    records one press at each place shown, then saves a calibration for play and replay --calibration
  gelpad calibrate --presses mine.csv -o mine.json
    learns a calibration from recorded presses
  gelpad calibrate --presses train.csv --evaluate test.csv
    locates the presses of test.csv from their voltages; needs no pad, prints one JSON object
  gelpad calibrate --presses mine.csv --size 80x80 -o skin.toml
    learns a pad that plays without a drawing: gelpad play --pad ./skin.toml
  gelpad calibrate --source serial:/dev/ttyACM0 --recommend anna
    asks for short, long and double presses, then writes settings for this user

Presses are CSV: x_mm,y_mm,d0,d1,... with the differences pressed - unpressed in any unit. For --evaluate, rows may hold
the places of two or three touches: x_mm,y_mm,x2_mm,y2_mm,x3_mm,y3_mm,d0,d1,... (empty where there are fewer). Presses recorded by gelpad
have force,model_x_mm,model_y_mm before d0; only these give a calibration. To learn a pad (-o FILE.toml) from other presses, a row without a
place (,,v0,v1,...) holds the untouched readings.")]
pub(in crate::cli) struct CalibrateArgs {
    /// A shipped pad, or a file (contains `/` or ends in `.toml`)
    #[arg(long, default_value = crate::pad::DEFAULT_PAD)]
    pub pad: String,
    /// Presses to learn from; with --source, the file for the recorded presses
    #[arg(long, value_name = "FILE", required_unless_present = "source")]
    pub presses: Option<PathBuf>,
    /// File of the calibration, or of a pad to learn: FILE.toml [default: PAD.calibration.json beside the pad's file, or here]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Size of a rectangular pad without a drawing, mm: WIDTHxHEIGHT
    #[arg(long, value_name = "WxH", value_parser = size_mm, requires = "output", conflicts_with_all = ["source", "pad"])]
    pub size: Option<[f64; 2]>,
    /// Locate these presses instead of saving, and print the errors
    #[arg(long, value_name = "FILE", conflicts_with_all = ["source", "output"])]
    pub evaluate: Option<PathBuf>,
    /// Record presses from simulated (a robot presses), serial:PORT or replay:FILE
    #[arg(long, value_parser = source)]
    pub source: Option<SourceChoice>,
    /// Number of places to press
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = points)]
    pub points: usize,
    /// Ask for presses and write settings for this user to users/NAME.toml, or to -o FILE
    #[arg(long, value_name = "NAME", requires = "source", conflicts_with_all = ["presses", "evaluate"])]
    pub recommend: Option<String>,
    /// The profile whose regions are pressed for --recommend
    #[arg(long, default_value = "super-mario-classified")]
    pub profile: String,
    /// Reconstruction while recording: tikhonov, noser, smooth or l1 [default: the pad's, else noser]
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

impl CalibrateArgs {
    /// Where presses come from, given what `--source` names.
    pub(in crate::cli) fn press_source<'a>(&self, choice: &'a SourceChoice) -> PressSource<'a> {
        PressSource {
            choice,
            board: self.board.line(),
            noise: NoiseLevel {
                snr_db: self.snr,
                seed: self.seed,
            },
        }
    }
}
