//! Wakes the thread that shows the game at every new view, without making the engine wait.

use std::sync::OnceLock;
use std::thread::Thread;

/// The thread to wake, if one was set.
#[derive(Debug, Default)]
pub(super) struct ViewWaker {
    thread: OnceLock<Thread>,
}

impl ViewWaker {
    /// Sets the thread; only the first call has an effect.
    pub(super) fn set_thread(&self, thread: Thread) {
        let _ = self.thread.set(thread);
    }

    pub(super) fn wake(&self) {
        if let Some(thread) = self.thread.get() {
            thread.unpark();
        }
    }
}
