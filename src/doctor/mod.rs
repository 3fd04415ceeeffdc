//! Whether this machine can play, and what to do where it cannot.
//!
//! ```text
//! Machine ─look─▶ facts ─judge─▶ lines: ok, or what is wrong and the command that mends it
//! ```
//! One file a check. What is looked at and what that means are apart: judging is pure, so that every fault can be
//! provoked in a test.

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
pub mod rule;
mod serial;
mod session;
mod wayland;
mod x11;

pub use line::{Line, State};
pub use machine::Machine;

/// Lines that belong together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// What they are about.
    pub title: &'static str,
    /// One or more.
    pub lines: Vec<Line>,
}

/// What the doctor has found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// In the order of the way of a press: device, desktop, board.
    pub sections: Vec<Section>,
    /// Outputs that work, best first.
    pub outputs: Vec<&'static str>,
    /// Boards that are plugged in, and whether one of them can be read.
    pub boards: Boards,
}

/// Serial ports that may be boards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boards {
    /// None is plugged in: the simulated pad plays.
    None,
    /// At least one can be read.
    Readable,
    /// None of those that are there.
    Unreadable,
}

impl Report {
    /// Whether `gelpad play` would work: some output takes its events, and a board that is there can be read.
    #[must_use]
    pub fn plays(&self) -> bool {
        !self.outputs.is_empty() && self.boards != Boards::Unreadable
    }
}

/// Looks at everything. Makes a gamepad for about a second, if it can.
#[must_use]
pub fn examine(machine: &Machine) -> Report {
    let module = module::look(machine);
    let node = node::look(machine);
    let rules = rule::look(machine);
    let pad = pad::look(&node);
    let mut device = vec![
        module::judge(&module),
        node::judge(&node, &module),
        rule::judge(&rules, &node),
    ];
    device.extend(pad::judge(&pad));

    let x11 = x11::look(machine);
    let wayland = wayland::look(machine);
    let desktop = vec![
        session::judge(&session::look(machine)),
        x11::judge(&x11),
        wayland::judge(&wayland, cfg!(feature = "wayland")),
    ];

    let ports = serial::look(machine);
    let mut board = serial::judge(&ports);
    board.extend(ftdi::judge(&ftdi::look(machine)));
    board.extend(groups::judge(&groups::look(machine)));

    let mut outputs = Vec::new();
    if pad.works() {
        outputs.push("gamepad, keyboard and mouse of the kernel");
    }
    if x11.works() {
        outputs.push("keyboard and mouse of the X11 display");
    }
    if wayland.works() && cfg!(feature = "wayland") {
        outputs.push("keyboard of the Wayland desktop");
    }
    Report {
        sections: vec![
            section("Devices of the kernel", device),
            section("Desktop", desktop),
            section("Board", board),
        ],
        outputs,
        boards: serial::boards(&ports),
    }
}

fn section(title: &'static str, lines: Vec<Line>) -> Section {
    Section { title, lines }
}
