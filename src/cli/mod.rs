//! The command line: one file a subcommand.
//!
//! Exit codes: 0 success; 1 failure; 2 what `--help` forbids; 3 finished but lost data; 130 and 143 after Ctrl-C and
//! SIGTERM, keys up. Machine-readable output goes to stdout, everything else to stderr.

mod accuracy;
mod args;
mod calibrate;
mod candidates;
mod changes;
mod device;
#[cfg(target_os = "linux")]
mod doctor;
mod drawing;
mod exit;
mod export;
mod files;
mod gamepads;
mod listen;
mod live;
mod log;
mod map;
mod outputs;
mod pads;
mod pick;
mod play;
mod played_with;
mod profiles;
mod progress;
mod recover;
mod replay;
mod resolve;
mod study;
#[cfg(feature = "gui")]
mod window;

use std::process::ExitCode;

use clap::Parser as _;

use args::{Arguments, Command};

/// Runs the command that the arguments name.
#[must_use]
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    log::start(arguments.verbose);
    let outcome = match arguments.command {
        #[cfg(feature = "gui")]
        None => window::open(),
        #[cfg(not(feature = "gui"))]
        None => play::level(),
        Some(Command::Play(args)) => play::play(&args),
        Some(Command::Replay(args)) => replay::replay(&args),
        Some(Command::Recover(args)) => recover::recover(&args),
        Some(Command::Export(args)) => export::export(&args),
        Some(Command::Listen(args)) => listen::listen(&args),
        Some(Command::Device(args)) => device::device(&args),
        Some(Command::Calibrate(args)) => calibrate::calibrate(&args),
        Some(Command::Pad { command }) => pads::run(&command),
        Some(Command::Profile { command }) => profiles::run(&command),
        Some(Command::Study { command }) => study::run(&command),
        Some(Command::Accuracy(args)) => accuracy::run(&args),
        #[cfg(target_os = "linux")]
        Some(Command::Watch { way, window }) => watch(way, window),
        #[cfg(target_os = "linux")]
        Some(Command::Doctor(args)) => doctor::run(&args),
        #[cfg(not(target_os = "linux"))]
        Some(Command::Doctor(_)) => Err(anyhow::anyhow!("the doctor knows Linux only")),
    };
    exit::code(outcome)
}

/// The whole life of a watcher.
#[cfg(target_os = "linux")]
fn watch(way: args::WayArg, window: u32) -> anyhow::Result<exit::Ending> {
    use crate::output::watch::{Way, watch};

    watch(match way {
        args::WayArg::X11 => Way::X11 { window },
        args::WayArg::Cut => Way::Cut,
    })?;
    Ok(exit::Ending::Done)
}
