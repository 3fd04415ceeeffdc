//! Single values on the command line.

use std::path::PathBuf;

use clap::ValueEnum;

/// What `--source` says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::cli) enum SourceArg {
    /// The simulated pad with a script, or with the level.
    Simulated(Option<PathBuf>),
    /// A board.
    Serial(String),
    /// A file, in real time.
    Replay(PathBuf),
    /// Gamepads and switches.
    Gamepad,
}

impl std::str::FromStr for SourceArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, rest) = match text.split_once(':') {
            Some((kind, rest)) => (kind, Some(rest).filter(|rest| !rest.is_empty())),
            None => (text, None),
        };
        match (kind, rest) {
            ("simulated", script) => Ok(Self::Simulated(script.map(PathBuf::from))),
            ("serial", Some(port)) => Ok(Self::Serial(port.to_owned())),
            ("replay", Some(file)) => Ok(Self::Replay(PathBuf::from(file))),
            ("gamepad", None) => Ok(Self::Gamepad),
            ("serial", None) => Err("which port? as in serial:/dev/ttyACM0".to_owned()),
            ("replay", None) => Err("which file? as in replay:frames.csv".to_owned()),
            _ => Err(
                "write simulated, simulated:SCRIPT, serial:PORT, replay:FILE or gamepad".to_owned(),
            ),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum OutputArg {
    /// The best there is, and one line that says why; with the simulated pad: trace
    Auto,
    /// Keys and mouse of this desktop; of the kernel where there is no display
    Keyboard,
    /// An Xbox 360 pad, a keyboard and a mouse of the Linux kernel (uinput)
    Gamepad,
    /// Events as text on stdout
    Trace,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum PrintArg {
    Touches,
    Events,
}

pub(super) fn seconds(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|number| (0.0..1e9).contains(number))
        .ok_or_else(|| "a number, 0 or more".to_owned())
}

pub(super) fn points(text: &str) -> Result<usize, String> {
    let range =
        crate::calibrate::FEWEST_PRESSES..=crate::touch::correction::MOST_CORRECTION_PRESSES;
    text.parse::<usize>()
        .ok()
        .filter(|points| range.contains(points))
        .ok_or_else(|| format!("a number of places, {} to {}", range.start(), range.end()))
}

pub(super) fn above_zero(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|number| *number > 0.0 && *number <= 1e6)
        .ok_or_else(|| "a number above 0".to_owned())
}

pub(super) fn rate(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|rate| *rate == 0.0 || (0.01..=1e5).contains(rate))
        .ok_or_else(|| "frames a second, 0.01 to 100000, or 0".to_owned())
}

pub(super) fn percent(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|percent| (0.0..=100.0).contains(percent))
        .ok_or_else(|| "a percentage, 0 to 100".to_owned())
}

pub(super) fn snr(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|db| (0.0..=300.0).contains(db))
        .ok_or_else(|| "a ratio in dB, 0 to 300".to_owned())
}
