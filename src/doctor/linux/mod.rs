//! The checks of Linux: kernel devices, desktop, board and timing.

mod delay;
mod ftdi;
#[cfg(gamepads)]
mod game;
mod groups;
mod machine;
mod module;
mod node;
mod pad;
mod priority;
pub mod rule;
mod serial;
mod session;
mod wayland;
mod x11;

pub use machine::Machine;

use super::{CheckLine, DoctorReport, section};

/// Runs all checks on this computer. Creates a test gamepad for about a second if possible.
#[must_use]
pub fn check_this_computer() -> DoctorReport {
    run_checks(&Machine::local())
}

/// What a virtual gamepad and gamepads as a source need on this computer; creates nothing.
#[must_use]
pub fn gamepad_lines() -> Vec<CheckLine> {
    gamepad_checks(&Machine::local())
}

/// Runs all checks on a machine. Creates a test gamepad for about a second if possible.
#[must_use]
pub fn run_checks(machine: &Machine) -> DoctorReport {
    let module = module::examine(machine);
    let node = node::examine(machine);
    let rules = rule::examine(machine);
    let pad = pad::examine(&node);
    let mut device = vec![
        module::judge(&module),
        node::judge(&node, &module),
        rule::judge(&rules, &node),
    ];
    device.extend(pad::judge(&pad));

    let x11 = x11::examine(machine);
    let wayland = wayland::examine(machine);
    let desktop = vec![
        session::check(machine),
        x11::judge(&x11),
        wayland::judge(&wayland, cfg!(feature = "wayland")),
    ];

    let ports = serial::examine(machine);
    let mut board = serial::judge(&ports);
    board.extend(ftdi::check(machine));
    board.extend(groups::judge(&groups::examine(machine)));

    let mut outputs = Vec::new();
    if pad.works() {
        outputs.push("kernel (gamepad, keyboard and mouse)");
    }
    if x11.works() {
        outputs.push("X11 display (keyboard and mouse)");
    }
    if wayland.works() && cfg!(feature = "wayland") {
        outputs.push("Wayland desktop (keyboard)");
    }
    DoctorReport {
        sections: vec![
            section("Kernel devices", device),
            section("Desktop", desktop),
            section("Board", board),
            section("Timing", vec![priority::check()]),
        ],
        outputs,
        boards: serial::boards(&ports),
    }
}

/// What a virtual gamepad and gamepads as a source need; creates nothing.
fn gamepad_checks(machine: &Machine) -> Vec<CheckLine> {
    const SOURCE: &str = "gamepads as a source";
    let module = module::examine(machine);
    let node = node::examine(machine);
    let source = match cfg!(gamepads) {
        true => CheckLine::ok(SOURCE, "built in"),
        false => CheckLine::wrong(
            SOURCE,
            "this gelpad was built without them (Debian: libudev-dev, pkg-config)",
            "cargo install --path . --features gilrs",
        ),
    };
    vec![module::judge(&module), node::judge(&node, &module), source]
}
