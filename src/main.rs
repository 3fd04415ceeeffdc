//! The `gelpad` command: runs the command line, or opens the window if there is no command.

use std::process::ExitCode;

use gelpad::app::services::WindowArguments;
use gelpad::cli::{self, Next};

fn main() -> ExitCode {
    gelpad::platform::console::prepare();
    match cli::run() {
        Next::Exit(code) => code,
        Next::OpenWindow(arguments) => open_window(arguments),
    }
}

#[cfg(not(feature = "gui"))]
fn open_window(_: WindowArguments) -> ExitCode {
    cli::play_level()
}

/// Opens the window; if that fails, prints why and plays the level in the terminal.
#[cfg(feature = "gui")]
fn open_window(arguments: WindowArguments) -> ExitCode {
    use std::sync::Arc;

    use gelpad::app::LocalServices;

    use gelpad::gui::{self, WindowOptions};
    use gelpad::platform::desktop::has_display;
    use gelpad::platform::signals::Signals;

    gelpad::platform::console::close_own();
    if !has_display() {
        tracing::warn!(
            "no window: there is no display (DISPLAY, WAYLAND_DISPLAY); the level plays here"
        );
        return cli::play_level();
    }
    let signals = match Signals::listen() {
        Ok(signals) => Arc::new(signals),
        Err(error) => {
            tracing::error!("signals cannot be caught: {error}");
            return ExitCode::FAILURE;
        }
    };
    let received = Arc::clone(&signals);
    let opened = gui::open(WindowOptions {
        services: Arc::new(LocalServices::default()),
        arguments,
        interrupted: Box::new(move || received.received().is_some()),
    });
    match opened {
        Ok(()) => cli::window_exit_code(signals.received()),
        Err(error) => {
            tracing::warn!("{error}; the level plays here");
            cli::play_level()
        }
    }
}
