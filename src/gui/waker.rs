//! Requests a repaint when the game has a new view, as often as `repaint_rate.rs` says at most, at once when a touch comes or goes
//! or an event is sent, and every 10 s while no view comes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{Builder, JoinHandle, Thread};
use std::time::Duration;

use super::repaint_rate;

/// Shortest time between repaints at first.
const MIN_INTERVAL: Duration = Duration::from_millis(16);
/// Without a delay, egui repaints twice for each request.
const ONCE: Duration = Duration::from_millis(1);
/// How often changes are looked for between repaints: a touch is shown this much later at most.
const STEP: Duration = Duration::from_millis(10);
/// Longest time between repaints.
const MAX_INTERVAL: Duration = Duration::from_secs(10);

/// The thread; ends when this is dropped.
pub struct Waker {
    stop: Arc<AtomicBool>,
    /// Shortest time between repaints without a change, ms.
    interval_ms: Arc<AtomicU64>,
    /// Counts what the player should see at once.
    changes: Arc<AtomicU64>,
    thread: Option<JoinHandle<()>>,
}

impl Waker {
    /// Starts the thread.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn start(ctx: egui::Context) -> std::io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let interval_ms = Arc::new(AtomicU64::new(MIN_INTERVAL.as_millis() as u64));
        let changes = Arc::new(AtomicU64::new(0));
        let (stopping, shortest_ms, counter) = (
            Arc::clone(&stop),
            Arc::clone(&interval_ms),
            Arc::clone(&changes),
        );
        let thread = Builder::new().name("waker".to_owned()).spawn(move || {
            let mut seen = 0;
            while !stopping.load(Ordering::Relaxed) {
                std::thread::park_timeout(MAX_INTERVAL);
                ctx.request_repaint_after(ONCE);
                std::thread::sleep(MIN_INTERVAL);
                let mut waited = MIN_INTERVAL;
                loop {
                    let shortest = Duration::from_millis(shortest_ms.load(Ordering::Relaxed));
                    let has_changed =
                        counter.load(Ordering::Relaxed) != seen && shortest < repaint_rate::HIDDEN;
                    if waited >= shortest || has_changed || stopping.load(Ordering::Relaxed) {
                        break;
                    }
                    std::thread::sleep(STEP);
                    waited += STEP;
                }
                seen = counter.load(Ordering::Relaxed);
            }
        })?;
        Ok(Self {
            stop,
            interval_ms,
            changes,
            thread: Some(thread),
        })
    }

    /// Sets the shortest time between repaints.
    pub fn set_interval(&self, interval: Duration) {
        let interval_ms = interval.as_millis().min(MAX_INTERVAL.as_millis());
        self.interval_ms
            .store(interval_ms as u64, Ordering::Relaxed);
    }

    /// The counter that a game increments for what the player should see at once.
    pub fn changes(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.changes)
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
