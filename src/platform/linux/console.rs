//! Consoles need nothing here: terminals understand colours, and a program opens none.

/// Prepares the console for coloured text.
pub fn prepare() {}

/// Closes a console that was opened for this program alone.
pub fn close_own() {}
