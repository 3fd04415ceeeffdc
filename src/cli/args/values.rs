//! Parsers of single arguments.

use std::path::PathBuf;

use clap::ValueEnum;

use crate::app::services::{OutputChoice, SourceChoice};

/// Reads `--source`.
pub(super) fn source(text: &str) -> Result<SourceChoice, String> {
    let (kind, rest) = match text.split_once(':') {
        Some((kind, rest)) => (kind, Some(rest).filter(|rest| !rest.is_empty())),
        None => (text, None),
    };
    match (kind, rest) {
        ("simulated", None) => Ok(SourceChoice::Level),
        ("simulated", Some(script)) => Ok(SourceChoice::Script(PathBuf::from(script))),
        ("serial", Some(port)) => Ok(SourceChoice::Serial(port.to_owned())),
        ("replay", Some(file)) => Ok(SourceChoice::Replay(PathBuf::from(file))),
        ("gamepad", None) => Ok(SourceChoice::Gamepad),
        ("serial", None) => Err("the port is missing: write serial:/dev/ttyACM0".to_owned()),
        ("replay", None) => Err("the file is missing: write replay:frames.csv".to_owned()),
        _ => Err(
            "expected simulated, simulated:SCRIPT, serial:PORT, replay:FILE or gamepad".to_owned(),
        ),
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum OutputArg {
    /// The best output of this computer, with a line that says why; trace for the simulated pad
    Auto,
    /// Keyboard and mouse of the desktop, or of the kernel without a display
    Keyboard,
    /// Xbox 360 gamepad, keyboard and mouse of the Linux kernel (uinput)
    Gamepad,
    /// Events as text on stdout
    Trace,
}

impl From<OutputArg> for OutputChoice {
    fn from(output: OutputArg) -> Self {
        match output {
            OutputArg::Auto => Self::Auto,
            OutputArg::Keyboard => Self::Keyboard,
            OutputArg::Gamepad => Self::Gamepad,
            OutputArg::Trace => Self::Trace,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum PrintArg {
    Touches,
    Events,
}

/// A number that `is_valid` accepts; `expected` describes it.
fn number(text: &str, is_valid: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok();
    let number = number.filter(|number| is_valid(*number));
    number.ok_or_else(|| format!("expected {expected}"))
}

pub(super) fn seconds(text: &str) -> Result<f64, String> {
    number(text, |s| (0.0..1e9).contains(&s), "a number, 0 or more")
}

pub(super) fn above_zero(text: &str) -> Result<f64, String> {
    number(text, |n| n > 0.0 && n <= 1e6, "a number above 0")
}

pub(super) fn rate(text: &str) -> Result<f64, String> {
    let is_valid = |rate| rate == 0.0 || (0.01..=1e5).contains(&rate);
    number(text, is_valid, "frames per second, 0.01 to 100000, or 0")
}

pub(super) fn percent(text: &str) -> Result<f64, String> {
    let is_valid = |percent| (0.0..=100.0).contains(&percent);
    number(text, is_valid, "a percentage, 0 to 100")
}

pub(super) fn snr(text: &str) -> Result<f64, String> {
    number(
        text,
        |db| (0.0..=300.0).contains(&db),
        "a ratio in dB, 0 to 300",
    )
}

/// The width and height of a pad.
pub(super) fn size_mm(text: &str) -> Result<[f64; 2], String> {
    let sides = text.split_once('x').and_then(|(width, height)| {
        let side = |text: &str| text.trim().parse::<f64>().ok().filter(|side| *side > 0.0);
        Some([side(width)?, side(height)?])
    });
    sides.ok_or_else(|| "expected width and height in mm, such as 80x60".to_owned())
}

pub(super) fn points(text: &str) -> Result<usize, String> {
    let range =
        crate::calibrate::FEWEST_PRESSES..=crate::touch::correction::MOST_CORRECTION_PRESSES;
    text.parse::<usize>()
        .ok()
        .filter(|points| range.contains(points))
        .ok_or_else(|| {
            format!(
                "expected a number of places, {} to {}",
                range.start(),
                range.end()
            )
        })
}
