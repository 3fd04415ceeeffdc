//! The command line: one file a subcommand.
//!
//! Exit codes: 0 success; 1 failure; 2 what `--help` forbids; 3 finished but lost data; 130 and 143 after Ctrl-C and
//! SIGTERM, keys up. Machine-readable output goes to stdout, everything else to stderr.

mod args;
mod exit;
mod live;
mod map;
mod pads;
mod play;
mod profiles;
mod replay;
mod resolve;
mod study;

use std::io::IsTerminal as _;
use std::process::ExitCode;

use clap::Parser as _;

use args::{Arguments, Command};

/// Runs the command that the arguments name.
#[must_use]
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    start_log(arguments.verbose);
    let outcome = match arguments.command {
        None => play::level(),
        Some(Command::Play(args)) => play::play(&args),
        Some(Command::Replay(args)) => replay::replay(&args),
        Some(Command::Pad { command }) => pads::run(&command),
        Some(Command::Profile { command }) => profiles::run(&command),
        Some(Command::Study { command }) => study::run(&command),
    };
    exit::code(outcome)
}

/// Logs go to stderr: warnings always, more with `-v` or `RUST_LOG`.
fn start_log(verbose: u8) {
    use tracing_subscriber::EnvFilter;

    let default = ["warn", "info", "debug"][usize::from(verbose.min(2))];
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(default));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .without_time()
        .with_target(false)
        .init();
}
