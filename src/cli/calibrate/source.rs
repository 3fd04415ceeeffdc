//! Opens the source of presses.

use anyhow::bail;

use crate::app::services::{NoiseLevel, SourceChoice};
use crate::app::source::open_pad_source;
use crate::cli::args::CalibrateArgs;
use crate::pad::Pad;
use crate::source::{Noise, RobotSource, Source};
use crate::types::PointMm;

/// Opens a source; on the simulated pad without a script, a robot presses the places.
pub(super) fn open(
    args: &CalibrateArgs,
    pad: &Pad,
    source: &SourceChoice,
    places: &[PointMm],
) -> anyhow::Result<Box<dyn Source>> {
    let level = NoiseLevel {
        snr_db: args.snr,
        seed: args.seed,
    };
    let mut opened: Box<dyn Source> = match source {
        SourceChoice::Level if places.is_empty() => {
            bail!("the simulated pad is not pressed: give a script, such as simulated:presses.txt")
        }
        SourceChoice::Level => {
            let noise = Noise::new(args.snr, args.seed);
            Box::new(RobotSource::new(pad, places.to_vec(), noise, args.seed)?)
        }
        SourceChoice::Gamepad => bail!("a gamepad has no places to calibrate"),
        source => open_pad_source(source, args.board.line(), level, pad)?,
    };
    opened.require_frames();
    Ok(opened)
}
