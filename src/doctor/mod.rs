//! Checks whether this machine can play, and names the fix for each fault.
//!
//! ```text
//! Machine ─examine─▶ facts ─judge─▶ lines: ok, note, or wrong with its fix
//! ```
//! One file per check. `judge` is pure, and a [`Machine`] can be a folder, so that tests can provoke every fault.

mod delay;
mod ftdi;
#[cfg(feature = "gilrs")]
mod game;
mod groups;
mod line;
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

pub use line::{CheckLine, CheckStatus};
pub use machine::Machine;

/// A section of the report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReportSection {
    /// Heading.
    pub title: &'static str,
    /// Results of its checks, at least one.
    pub lines: Vec<CheckLine>,
}

/// Results of all checks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DoctorReport {
    /// Kernel devices, desktop, board, timing.
    pub sections: Vec<ReportSection>,
    /// Outputs that work, best first.
    pub outputs: Vec<&'static str>,
    /// Whether a board can be read.
    pub boards: BoardAccess,
}

/// CheckStatus of the serial ports that may be boards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoardAccess {
    /// No board is plugged in.
    None,
    /// At least one board can be read.
    Readable,
    /// BoardAccess are plugged in, and none can be read.
    Unreadable,
}

impl DoctorReport {
    /// Whether `gelpad play` would work: an output works, and a board that is plugged in can be read.
    #[must_use]
    pub fn can_play(&self) -> bool {
        !self.outputs.is_empty() && self.boards != BoardAccess::Unreadable
    }
}

/// Runs all checks. Creates a test gamepad for about a second if possible.
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
#[must_use]
pub fn gamepad_checks(machine: &Machine) -> Vec<CheckLine> {
    const SOURCE: &str = "gamepads as a source";
    let module = module::examine(machine);
    let node = node::examine(machine);
    let source = match cfg!(feature = "gilrs") {
        true => CheckLine::ok(SOURCE, "built in"),
        false => CheckLine::wrong(
            SOURCE,
            "this gelpad was built without them (Debian: libudev-dev, pkg-config)",
            "cargo install --path . --features gilrs",
        ),
    };
    vec![module::judge(&module), node::judge(&node, &module), source]
}

fn section(title: &'static str, lines: Vec<CheckLine>) -> ReportSection {
    ReportSection { title, lines }
}
