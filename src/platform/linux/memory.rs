//! What the program keeps of memory that it has freed.

/// Returns large freed blocks to the system at once, for programs that run for hours after they have solved something. glibc keeps
/// them otherwise: after a large block was freed once, it takes blocks of that size from its heap, where smaller ones pin them. A
/// third of the window's memory was such blocks.
#[allow(unsafe_code, reason = "no safe interface sets a threshold of malloc")]
pub fn return_freed_blocks() {
    /// Larger blocks are mapped and unmapped, bytes. The initial value of glibc; setting it keeps it from growing.
    const THRESHOLD: libc::c_int = 128 * 1024;
    // SAFETY: `mallopt` only sets a parameter of malloc.
    let _ = unsafe { libc::mallopt(libc::M_MMAP_THRESHOLD, THRESHOLD) };
}

/// Returns what is free inside the heaps now. Takes a few milliseconds, and other threads wait for a heap while it is trimmed.
#[allow(unsafe_code, reason = "no safe interface trims the heaps of malloc")]
pub fn trim_heaps() {
    // SAFETY: `malloc_trim` has no preconditions; it takes the locks of the heaps itself.
    let _ = unsafe { libc::malloc_trim(0) };
}
