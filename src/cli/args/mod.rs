//! The arguments of the command line. Their names are a contract: scripts use them.

mod board;
mod calibrate;
mod play;
mod recordings;
mod study;
mod texts;
mod values;
mod window;

pub(super) use board::{DeviceArgs, LayoutArg, ListenArgs};
pub(super) use calibrate::CalibrateArgs;
pub(super) use play::PlayArgs;
pub(super) use recordings::{ExportArgs, ExportFormat, RecoverArgs, ReplayArgs};
pub(super) use study::{AccuracyArgs, StudyArgs, StudyCommand};
pub(super) use texts::{IdentifyArgs, PadCommand, ProfileCommand, ShowArgs};
pub(super) use values::{OutputArg, PrintArg};
pub(super) use window::WindowArgs;

use clap::{Args, Parser, Subcommand, ValueEnum};

/// Version, commit and features of this build.
const VERSION: &str = concat!(
    env!("CARGO_PKG_VERSION"),
    " (",
    env!("GELPAD_COMMIT"),
    "; ",
    env!("GELPAD_FEATURES"),
    ")"
);

/// Play games on a soft sheet of hydrogel.
///
/// Without a command, gelpad opens a window with the game of the last session, at first the simulated pad; without a display,
/// it plays a scripted level in this terminal. No keys are sent to your desktop until you choose an output.
#[derive(Debug, Parser)]
#[command(
    name = "gelpad",
    version = VERSION,
    after_help = "Example: gelpad play super-mario --source serial:/dev/ttyACM0"
)]
pub(super) struct Arguments {
    /// More log lines (-vv: even more); RUST_LOG selects them in detail
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
    #[command(flatten)]
    pub window: WindowArgs,
    #[command(subcommand)]
    pub command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Play: turn touches into key presses
    Play(PlayArgs),
    /// Replay a recording, or turn frames into touches or events, as fast as possible
    Replay(ReplayArgs),
    /// Save the readable part of a damaged recording
    Recover(RecoverArgs),
    /// Convert a recording for other programs
    Export(ExportArgs),
    /// Show what a board sends: rate, values, order, likely format, first bad line
    Listen(ListenArgs),
    /// Simulate a board on a pseudo-terminal
    Device(DeviceArgs),
    /// Learn a calibration, a pad, or settings for a user, from presses at known places
    Calibrate(CalibrateArgs),
    /// List, check and show pads
    Pad {
        #[command(subcommand)]
        command: PadCommand,
    },
    /// List, check and show profiles
    Profile {
        #[command(subcommand)]
        command: ProfileCommand,
    },
    /// Run a study of pad designs
    Study {
        #[command(subcommand)]
        command: StudyCommand,
    },
    /// Estimate how accurately a pad locates touches, and what limits it
    Accuracy(AccuracyArgs),
    /// Release the keys of the gelpad that started this process, when it is killed or stopped
    #[command(hide = true, alias = "guard")]
    Watch {
        /// How keys are released
        #[arg(value_enum)]
        way: WayArg,
        /// X11: a window of the connection
        #[arg(long, default_value_t = 0)]
        window: u32,
        /// Windows: the process that is watched
        #[arg(long, default_value_t = 0)]
        parent: u32,
    },
    /// Check whether this computer can play, and print what to fix
    Doctor(DoctorArgs),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum WayArg {
    /// Send releases to the X11 display
    X11,
    /// Close the connection on standard output
    Cut,
    /// Send releases to the desktop of this session (Windows)
    Keys,
}

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  gelpad doctor                            prints a line per check, with the command that fixes a problem
  sudo gelpad doctor --install-rule        lets the logged-in user create gamepads; prints first what it will do

The exit code is 1 if playing would not work. The check creates a gamepad for a second, and on X11 presses an unused key.")]
pub(super) struct DoctorArgs {
    /// Install the udev rule for gamepads and FTDI adapters; prints first what will be done
    #[arg(long)]
    pub install_rule: bool,
}
