//! What the desktop can show.

/// Whether windows can be see-through.
#[must_use]
pub fn can_be_transparent() -> bool {
    true
}

/// Whether a window can open.
#[must_use]
pub fn has_display() -> bool {
    true
}
