//! gelpad's devices as games see them, and gamepads as gelpad sees them, on a real kernel: in a virtual
//! machine (`scripts/run-in-guest.sh`), because a container has no input devices.
//!
//! This program runs itself again in the guest: `guest --inside NAME` runs one of the parts below; its exit
//! code is the result. If the guest or a program for it is missing, a trial is ignored with the reason as its
//! kind; with `GELPAD_TEST_ALL=1` it fails.

// The guest's game shares modules with the game test, though not all items.
#[path = "game/log.rs"]
#[allow(dead_code)]
mod log;
#[path = "game/process.rs"]
#[allow(dead_code)]
mod process;
#[path = "game/script.rs"]
#[allow(dead_code)]
mod script;
#[path = "game/tools.rs"]
#[allow(dead_code)]
mod tools;

#[path = "guest/as_evdev.rs"]
mod as_evdev;
#[cfg(feature = "gilrs")]
#[path = "guest/as_gilrs.rs"]
mod as_gilrs;
#[path = "guest/as_sdl.rs"]
mod as_sdl;
#[path = "guest/game.rs"]
mod game;
#[path = "guest/host.rs"]
mod host;
#[path = "guest/pad.rs"]
mod pad;
#[path = "guest/rumble.rs"]
mod rumble;
#[cfg(feature = "gilrs")]
#[path = "guest/source.rs"]
mod source;

use std::process::ExitCode;

use libtest_mimic::{Arguments, Trial};

use host::{Guest, trial};

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    if arguments.next().as_deref() == Some("--inside") {
        return inside(&arguments.next().unwrap_or_default());
    }
    let mut arguments = Arguments::from_args();
    // Each guest uses one processor.
    arguments.test_threads = Some(1);
    libtest_mimic::run(&arguments, trials()).exit_code()
}

fn trials() -> Vec<Trial> {
    let mut trials = vec![
        trial("evdev reads an Xbox 360 pad", Guest::needs(), || {
            Guest::default().inside("as-evdev")
        }),
        trial("SDL2 reads an Xbox 360 pad", as_sdl::needs(), || {
            as_sdl::build()?;
            Guest::default().inside("as-sdl")
        }),
        trial("fceux plays by the pad", game::needs(), game::play),
        trial("a game shakes the pad", Guest::needs(), || {
            Guest::default().inside("rumble")
        }),
    ];
    let of_gilrs = [
        ("gilrs reads an Xbox 360 pad", "as-gilrs", false),
        (
            "gilrs reads an Xbox 360 pad where udev runs",
            "as-gilrs",
            true,
        ),
        (
            "a gamepad plays a profile, with bounce keys",
            "source",
            false,
        ),
        ("a gamepad plays where udev runs", "source", true),
        (
            "a gamepad that is plugged in again plays on",
            "replug",
            false,
        ),
        ("and where udev runs", "replug", true),
        ("gelpad does not play itself", "loop", false),
    ];
    trials.extend(of_gilrs.map(|(name, part, udev)| {
        trial(name, host::needs_gilrs(), move || {
            Guest {
                udev,
                ..Guest::default()
            }
            .inside(part)
        })
    }));
    trials
}

/// Runs a part in the guest.
fn inside(part: &str) -> ExitCode {
    let outcome = match part {
        "as-evdev" => as_evdev::read(),
        "as-sdl" => as_sdl::read(),
        "game" => game::inside(),
        "rumble" => rumble::shake(),
        #[cfg(feature = "gilrs")]
        "as-gilrs" => as_gilrs::read(),
        #[cfg(feature = "gilrs")]
        "source" => source::play(),
        #[cfg(feature = "gilrs")]
        "replug" => source::replug(),
        #[cfg(feature = "gilrs")]
        "loop" => source::play_beside_own(),
        _ => Err(anyhow::anyhow!("no part is named {part}")),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error:#}");
            ExitCode::FAILURE
        }
    }
}
