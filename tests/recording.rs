//! Recordings end to end: exact replay on any processor, killed, cut, full, forged and old files, and other programs that read
//! them.
//!
//! Some trials need programs that may be missing (a virtual machine, fceux, Python packages): then they are ignored, with the
//! reason as their kind; with `GELPAD_TEST_ALL=1` they fail. By hand: `GELPAD_KILLS=100` sets the number of kills,
//! `-- --ignored hour` replays an hour.

#![allow(clippy::unwrap_used, reason = "a test")]

#[path = "recording/damage.rs"]
mod damage;
#[path = "recording/exports.rs"]
mod exports;
#[path = "recording/failures.rs"]
mod failures;
#[path = "recording/forged.rs"]
mod forged;
#[path = "game/process.rs"]
#[allow(dead_code, reason = "shared with the game's test")]
mod process;
#[path = "recording/replays.rs"]
mod replays;
#[path = "recording/sessions.rs"]
mod sessions;
#[path = "game/tools.rs"]
#[allow(dead_code, reason = "shared with the game's test")]
mod tools;
#[path = "recording/tuio.rs"]
mod tuio;
#[path = "recording/version_1.rs"]
mod version_1;

use std::path::Path;
use std::process::{Command, ExitCode, Output};

use anyhow::{Result, ensure};
use libtest_mimic::{Arguments, Failed, Trial};

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let needs = |name, missing: Option<String>, run: fn() -> Result<()>| match missing {
        Some(missing) if !tools::all_required() => {
            trial(name, run).with_kind(missing).with_ignored_flag(true)
        }
        _ => trial(name, run),
    };
    let trials = vec![
        // The longest first, since two run at a time.
        needs(
            "in_a_guest_without_avx2",
            replays::no_guest(),
            replays::in_guest,
        ),
        needs(
            "slim_in_a_guest_without_avx2",
            replays::no_guest(),
            replays::slim_in_guest,
        ),
        needs("a_movie_in_fceux", exports::no_fceux(), exports::movie),
        trial("a_session_replays_to_the_bit", replays::to_the_bit),
        trial(
            "another_profile_plays_the_same_touches",
            replays::with_another_profile,
        ),
        trial("uncorrected_contacts", replays::uncorrected_contacts),
        trial("expectations", replays::expectations),
        trial("a_stretch_of_time", replays::stretch),
        trial("too_few_frames_are_reported", replays::too_few),
        trial("play_takes_a_recording_as_source", replays::as_source),
        trial("size_of_a_frame", replays::size),
        trial("killed_while_recording", failures::killed),
        trial("a_full_disk", failures::full_disk),
        trial("damage_in_the_middle", failures::damaged),
        trial("flips_and_cuts", damage::flips_and_cuts),
        trial("damaged_heads", damage::damaged_heads),
        trial("a_damaged_table", damage::damaged_table),
        trial("bombs_and_lies", forged::refused),
        trial("csv_and_evemu", exports::texts),
        trial("a_part_within_a_press", exports::part_within_a_press),
        trial("touches_by_udp", tuio::by_udp),
        trial("version_1", version_1::replays),
        trial("an_hour", replays::hour).with_ignored_flag(true),
        needs("mcap_of_python", no_python("mcap"), exports::python),
        needs("tuio_of_python", no_python("pythontuio"), tuio::python),
    ];
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn trial(name: &str, run: fn() -> Result<()>) -> Trial {
    Trial::test(name, move || {
        run().map_err(|error| Failed::from(format!("{error:#}")))
    })
}

/// The Python with the packages: that of `GELPAD_PYTHON`, if set.
fn python() -> Command {
    Command::new(std::env::var_os("GELPAD_PYTHON").unwrap_or("python3".into()))
}

fn no_python(package: &str) -> Option<String> {
    let found = python().args(["-c", &format!("import {package}")]).output();
    let has = found.is_ok_and(|output| output.status.success());
    (!has).then(|| format!("no Python package {package}"))
}

/// Runs gelpad with arguments in a folder.
fn gelpad(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelpad"));
    command
        .args(arguments)
        .current_dir(folder)
        .env_remove("DISPLAY")
        .env("RUST_LOG", "info");
    command.output().expect("gelpad starts")
}

/// Runs gelpad and checks its exit code.
fn gelpad_ends(folder: &Path, arguments: &[&str], code: i32) -> Result<Output> {
    let output = gelpad(folder, arguments);
    ensure!(
        output.status.code() == Some(code),
        "gelpad {} ended {:?}, not {code}\n{}",
        arguments.join(" "),
        output.status,
        said(&output)
    );
    Ok(output)
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The setup of the sessions' engine.
fn config_setup() -> gelpad::session::Setup {
    sessions::config().to_setup()
}
