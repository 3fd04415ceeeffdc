//! How a watcher process releases what is down.

/// How a watcher releases what is down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReleaseMethod {
    /// It sends releases over its own connection to the X11 display that `DISPLAY` names.
    X11 {
        /// A window of the parent's connection: while it exists, a press of the parent may still be on its way.
        window: u32,
    },
    /// It shuts down the parent's connection, which it shares: the compositor then releases what the client held.
    CutConnection,
    /// It sends releases to the desktop of its session.
    Keys {
        /// Number of the process that is watched.
        parent: u32,
    },
}
