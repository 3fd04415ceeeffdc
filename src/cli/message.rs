//! Lines for the user on stderr.

use std::io::Write as _;

/// Prints a line on stderr; a closed stderr is ignored.
pub(super) fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}
