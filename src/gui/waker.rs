//! Asks for a repaint when the game has a newer view: not more often than a screen shows, and not at all while nothing comes,
//! but for a rare look at what is saved elsewhere: whoever comes back to the window moves the mouse, which is a look too.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle, Thread};
use std::time::Duration;

/// Least time between repaints: some 70 a second.
const PACE: Duration = Duration::from_millis(13);
/// Longest time between looks.
const LOOK: Duration = Duration::from_secs(10);

/// The thread; dropping it ends it.
pub struct Waker {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Waker {
    /// Starts it for a window.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(ctx: egui::Context) -> std::io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let stopping = Arc::clone(&stop);
        let thread = Builder::new().name("waker".to_owned()).spawn(move || {
            while !stopping.load(Ordering::Relaxed) {
                std::thread::park_timeout(LOOK);
                ctx.request_repaint();
                std::thread::sleep(PACE);
            }
        })?;
        Ok(Self {
            stop,
            thread: Some(thread),
        })
    }

    /// Whom a game is to wake.
    #[must_use]
    pub fn thread(&self) -> Option<Thread> {
        self.thread.as_ref().map(|thread| thread.thread().clone())
    }
}

impl Drop for Waker {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            let _ = thread.join();
        }
    }
}
