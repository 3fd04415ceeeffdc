//! Requests a repaint when the game has a new view, as often as `repaint_rate.rs` says at most, and every 10 s while no view comes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{Builder, JoinHandle, Thread};
use std::time::Duration;

/// Shortest time between repaints at first.
const MIN_INTERVAL: Duration = Duration::from_millis(16);
/// Without a delay, egui repaints twice for each request.
const ONCE: Duration = Duration::from_millis(1);
/// Longest time between repaints.
const MAX_INTERVAL: Duration = Duration::from_secs(10);

/// The thread; ends when this is dropped.
pub struct Waker {
    stop: Arc<AtomicBool>,
    /// Shortest time between repaints, ms.
    interval_ms: Arc<AtomicU64>,
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
        let interval_ms = Arc::new(AtomicU64::new(MIN_INTERVAL.as_millis() as u64));
        let shortest_ms = Arc::clone(&interval_ms);
        let thread = Builder::new().name("waker".to_owned()).spawn(move || {
            while !stopping.load(Ordering::Relaxed) {
                std::thread::park_timeout(MAX_INTERVAL);
                ctx.request_repaint_after(ONCE);
                let shortest_ms = shortest_ms.load(Ordering::Relaxed);
                std::thread::sleep(Duration::from_millis(shortest_ms));
            }
        })?;
        Ok(Self {
            stop,
            interval_ms,
            thread: Some(thread),
        })
    }

    /// Sets the shortest time between repaints.
    pub fn set_interval(&self, interval: Duration) {
        let interval_ms = interval.as_millis().min(MAX_INTERVAL.as_millis());
        self.interval_ms
            .store(interval_ms as u64, Ordering::Relaxed);
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
