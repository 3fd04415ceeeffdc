//! Wakes the thread that shows the game at every new view, without making the engine wait.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::Thread;

use super::View;
use crate::types::TouchId;

/// The thread to wake, and the counter of changes; none before they were set.
#[derive(Debug, Default)]
pub(super) struct ViewWaker {
    listener: OnceLock<(Thread, Arc<AtomicU64>)>,
}

impl ViewWaker {
    /// Sets the thread and the counter; only the first call has an effect.
    pub(super) fn set_listener(&self, thread: Thread, changes: Arc<AtomicU64>) {
        let _ = self.listener.set((thread, changes));
    }

    /// Wakes the thread; counts a change first if there was one.
    pub(super) fn wake(&self, has_changed: bool) {
        if let Some((thread, changes)) = self.listener.get() {
            if has_changed {
                changes.fetch_add(1, Ordering::Relaxed);
            }
            thread.unpark();
        }
    }
}

/// What a player should see at once: touches that come or go, events, pause and profile. Noise of the image is none of it.
#[derive(Debug, Default)]
pub(super) struct ChangeDetector {
    touches: Vec<TouchId>,
    events: u64,
    paused: bool,
    profile: usize,
}

impl ChangeDetector {
    /// Whether a view differs from the one of the last call.
    pub(super) fn update(&mut self, view: &View) -> bool {
        let profile = Arc::as_ptr(&view.profile).addr();
        let ids = view.touches.iter().map(|touch| touch.id);
        let is_same = self.events == view.events_so_far
            && self.paused == view.paused
            && self.profile == profile
            && ids.clone().eq(self.touches.iter().copied());
        if is_same {
            return false;
        }
        self.touches.clear();
        self.touches.extend(ids);
        self.events = view.events_so_far;
        self.paused = view.paused;
        self.profile = profile;
        true
    }
}
