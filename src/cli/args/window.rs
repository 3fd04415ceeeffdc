//! The arguments of `gelpad` without a command, which opens the window.

use std::path::PathBuf;

use clap::Args;

use super::values::source;
use crate::app::calibration::pad_and_calibration;
use crate::app::services::{SourceChoice, WindowArguments};

#[derive(Args, Clone, Debug, Default, PartialEq, Eq)]
#[command(
    next_help_heading = "Window (without a command; what is left out stays as in the last session)"
)]
pub(in crate::cli) struct WindowArgs {
    /// A profile by name, or a file
    #[arg(long)]
    pub profile: Option<String>,
    /// A pad by name, or a file
    #[arg(long)]
    pub pad: Option<String>,
    /// Settings of one user: a name, or a file
    #[arg(long, value_name = "NAME")]
    pub user: Option<String>,
    /// Where frames come from: `simulated` (your mouse), `simulated:SCRIPT`, `serial:PORT`, `replay:FILE` or `gamepad`
    #[arg(long, value_parser = source)]
    pub source: Option<SourceChoice>,
    /// A calibration or learned pad (FILE.toml) from `gelpad calibrate`, or a calibration from the window
    #[arg(long, value_name = "FILE")]
    pub calibration: Option<PathBuf>,
}

impl From<WindowArgs> for WindowArguments {
    fn from(args: WindowArgs) -> Self {
        let (pad, calibration) = pad_and_calibration(args.pad, args.calibration);
        Self {
            profile: args.profile,
            pad,
            user: args.user,
            source: args.source.map(|source| match source {
                // In the window the mouse presses the simulated pad.
                SourceChoice::Level => SourceChoice::Simulated,
                source => source,
            }),
            calibration,
        }
    }
}
