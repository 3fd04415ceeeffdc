//! What the program keeps of memory that it has freed.

/// The heap of Windows returns large blocks without being asked.
pub fn return_freed_blocks() {}

/// The heap of Windows trims itself.
pub fn trim_heaps() {}
