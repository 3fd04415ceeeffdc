//! There are no udev rules on this system.

use std::io;
use std::path::Path;

/// No rule.
pub const RULE: &str = "";
/// No path.
pub const RULE_PATH: &str = "";
/// No commands.
pub const COMMANDS: [&[&str]; 0] = [];

/// Explains that there is nothing to install.
///
/// # Errors
/// Always.
pub fn write(_: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Applies nothing.
#[must_use]
pub fn apply() -> Vec<String> {
    Vec::new()
}
