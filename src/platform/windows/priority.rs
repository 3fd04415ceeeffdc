//! The priority of the threads between a frame and its events, and of threads that solve pads.
#![allow(unsafe_code, reason = "no safe interface sets a priority")]

use windows_sys::Win32::System::Threading::{
    GetCurrentThread, SetThreadPriority, THREAD_PRIORITY, THREAD_PRIORITY_BELOW_NORMAL,
    THREAD_PRIORITY_HIGHEST,
};

/// Lets the calling thread run before ordinary programs.
pub fn raise() {
    set(THREAD_PRIORITY_HIGHEST);
}

/// Lets ordinary programs run before the calling thread.
pub fn lower() {
    set(THREAD_PRIORITY_BELOW_NORMAL);
}

fn set(priority: THREAD_PRIORITY) {
    // SAFETY: the handle stands for the calling thread and needs no closing.
    if unsafe { SetThreadPriority(GetCurrentThread(), priority) } == 0 {
        tracing::debug!("no other priority: {}", std::io::Error::last_os_error());
    }
}
