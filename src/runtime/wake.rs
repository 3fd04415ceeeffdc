//! Tells whoever shows the game that there is something newer to show: one flag and one thread to wake, so that the engine
//! never waits for a view.

use std::sync::OnceLock;
use std::thread::Thread;

/// Who is woken.
#[derive(Debug, Default)]
pub(super) struct Wake {
    thread: OnceLock<Thread>,
}

impl Wake {
    /// Names the thread; a second one is not taken.
    pub(super) fn who(&self, thread: Thread) {
        let _ = self.thread.set(thread);
    }

    /// Wakes it, if there is one.
    pub(super) fn wake(&self) {
        if let Some(thread) = self.thread.get() {
            thread.unpark();
        }
    }
}
