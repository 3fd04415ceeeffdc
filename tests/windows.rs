//! Windows: what a program sees of gelpad's keys, and that nothing stays down when gelpad is killed.
//!
//! A window of this program's own logs every key message with scan code, extended bit, virtual key and time, as a game would see
//! it. Runs on Windows and under wine (`scripts/test-windows.sh`); on other systems there are no trials.
//! `GELPAD_KEY_TABLE=FILE` writes the table of all keys, `GELPAD_KILLS` sets the number of kills.

#![allow(
    clippy::disallowed_methods,
    reason = "how long a key stays down is measured by the clock"
)]

#[cfg(windows)]
#[path = "windows/codes.rs"]
mod codes;
#[cfg(windows)]
#[path = "windows/keys.rs"]
mod keys;
#[cfg(windows)]
#[path = "windows/kills.rs"]
mod kills;
#[cfg(windows)]
#[path = "windows/logger.rs"]
mod logger;

use std::process::ExitCode;

use libtest_mimic::Arguments;

fn main() -> ExitCode {
    let is_watcher = std::env::args()
        .nth(1)
        .is_some_and(|command| command == "watch" || command == "guard");
    if is_watcher {
        // Outputs that are opened here start this program as their watchers.
        return match gelpad::cli::run() {
            gelpad::cli::Next::Exit(code) => code,
            gelpad::cli::Next::OpenWindow(_) => ExitCode::FAILURE,
        };
    }
    let mut arguments = Arguments::from_args();
    // All trials share the keyboard.
    arguments.test_threads = Some(1);
    libtest_mimic::run(&arguments, trials()).exit_code()
}

#[cfg(not(windows))]
fn trials() -> Vec<libtest_mimic::Trial> {
    Vec::new()
}

#[cfg(windows)]
fn trials() -> Vec<libtest_mimic::Trial> {
    use libtest_mimic::{Failed, Trial};

    let trial = |name: &str, run: fn() -> anyhow::Result<()>| {
        Trial::test(name, move || {
            run().map_err(|error| Failed::from(format!("{error:#}")))
        })
    };
    let is_wine = std::env::var_os("GELPAD_UNDER_WINE").is_some();
    let ctrl_break = trial("ctrl_break_releases_keys", kills::ctrl_break);
    vec![
        trial("every_key_arrives_with_its_scan_code", keys::table),
        trial("a_press_is_as_long_as_it_was", keys::lengths),
        trial("an_event_arrives_soon", keys::latency),
        trial("killed_gelpads_leave_nothing_down", kills::killed),
        trial("a_killed_watcher_is_not_missed", kills::with_a_watcher),
        trial(
            "the_end_of_the_session_releases_keys",
            kills::end_of_session,
        ),
        match is_wine {
            false => ctrl_break,
            // The script presses Ctrl-C in a terminal instead.
            true => ctrl_break
                .with_kind("wine sends no Ctrl-Break to a process group")
                .with_ignored_flag(true),
        },
    ]
}
