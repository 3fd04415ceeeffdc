//! The command line: one file per subcommand.
//!
//! Exit codes: 0 success; 1 failure; 2 wrong arguments; 3 finished but lost data; 130, 143 and 129 after Ctrl-C, SIGTERM
//! and a closed terminal, with all keys released. Machine-readable output goes to stdout, everything else to stderr.

mod accuracy;
mod args;
mod calibrate;
mod device;
mod doctor;
mod drawing;
mod exit;
mod export;
mod guided_presses;
mod identify;
mod input;
mod listen;
mod live;
mod log;
mod map;
mod message;
mod pads;
mod play;
mod profiles;
mod progress;
mod record_presses;
mod recover;
mod replay;
mod study;
mod summary;

use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{CommandFactory as _, Parser as _};

use crate::app::services::WindowArguments;
use crate::types::printable;
use args::{Arguments, Command, WindowArgs};
use input::copy_pipe;

/// What remains to be done after the command line was run.
pub enum Next {
    /// End with a code.
    Exit(ExitCode),
    /// Open the window: there was no command.
    OpenWindow(WindowArguments),
}

/// Runs the command of the arguments.
#[must_use]
pub fn run() -> Next {
    let arguments = Arguments::try_parse().unwrap_or_else(|error| end_with(&error));
    log::start(arguments.verbose);
    if arguments.command.is_some() && arguments.window != WindowArgs::default() {
        let message = "--profile, --pad, --user, --source and --calibration before a command belong to the window: write them after the command";
        let error = Arguments::command().error(ErrorKind::ArgumentConflict, message);
        end_with(&error);
    }
    let outcome = match arguments.command {
        None => return Next::OpenWindow(arguments.window.into()),
        Some(Command::Play(args)) => play::play(&args),
        Some(Command::Replay(mut args)) => {
            copy_pipe(&mut args.file).and_then(|_copy| replay::replay(&args))
        }
        Some(Command::Recover(mut args)) => {
            copy_pipe(&mut args.file).and_then(|_copy| recover::recover(&args))
        }
        Some(Command::Export(mut args)) => {
            copy_pipe(&mut args.file).and_then(|_copy| export::export(&args))
        }
        Some(Command::Listen(args)) => listen::listen(&args),
        Some(Command::Device(args)) => device::device(&args),
        Some(Command::Calibrate(args)) => calibrate::calibrate(&args),
        Some(Command::Pad { command }) => pads::run(&command),
        Some(Command::Profile { command }) => profiles::run(&command),
        Some(Command::Study { command }) => study::run(&command),
        Some(Command::Accuracy(args)) => accuracy::run(&args),
        Some(Command::Watch {
            way,
            window,
            parent,
        }) => watch(way, window, parent),
        Some(Command::Doctor(args)) => doctor::run(&args),
    };
    Next::Exit(exit::code(outcome))
}

/// Ends with help, or with a mistake in the arguments, which may hold any characters.
fn end_with(error: &clap::Error) -> ! {
    let plain = error.to_string();
    if error.use_stderr() && printable(&plain) != plain {
        message::say(plain.trim_end());
        std::process::exit(2);
    }
    error.exit()
}

/// The command line as clap knows it, for completions and man pages.
#[must_use]
pub fn command() -> clap::Command {
    Arguments::command()
}

/// Plays the level in the terminal.
#[must_use]
pub fn play_level() -> ExitCode {
    exit::code(play::play_level())
}

/// Exit code of a window that a signal ended, or that was closed.
#[must_use]
pub fn window_exit_code(signal: Option<i32>) -> ExitCode {
    exit::code(Ok(signal.map_or(exit::Ending::Done, exit::Ending::Signal)))
}

/// Runs as the watcher of another gelpad.
fn watch(way: args::WayArg, window: u32, parent: u32) -> anyhow::Result<exit::Ending> {
    use crate::platform::{ReleaseMethod, run_watcher};

    run_watcher(match way {
        args::WayArg::X11 => ReleaseMethod::X11 { window },
        args::WayArg::Cut => ReleaseMethod::CutConnection,
        args::WayArg::Keys => ReleaseMethod::Keys { parent },
    })?;
    Ok(exit::Ending::Done)
}
