//! Requests a repaint when the game has a new view, about 70 times a second at most, and every 10 s while no view comes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle, Thread};
use std::time::Duration;

/// Shortest time between repaints.
const MIN_INTERVAL: Duration = Duration::from_millis(13);
/// Longest time between repaints.
const MAX_INTERVAL: Duration = Duration::from_secs(10);

/// The thread; ends when this is dropped.
pub struct Waker {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Waker {
    /// Starts the thread.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn start(ctx: egui::Context) -> std::io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let stopping = Arc::clone(&stop);
        let thread = Builder::new().name("waker".to_owned()).spawn(move || {
            while !stopping.load(Ordering::Relaxed) {
                std::thread::park_timeout(MAX_INTERVAL);
                ctx.request_repaint();
                std::thread::sleep(MIN_INTERVAL);
            }
        })?;
        Ok(Self {
            stop,
            thread: Some(thread),
        })
    }

    /// The thread that a game unparks when it has a new view.
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
