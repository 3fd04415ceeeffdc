//! What the terminal of the live view reports, on every system.

/// A key of the live view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyCommand {
    /// q or Esc.
    Quit,
    /// Ctrl-C.
    Interrupt,
    /// p: pause, or continue.
    Pause,
    /// z: take the pad as it is as untouched.
    Rezero,
}

/// The terminal is closed.
#[derive(Clone, Copy, Debug)]
pub struct TerminalLost;
