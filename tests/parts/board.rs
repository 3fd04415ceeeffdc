//! A simulated board on a pseudo-terminal that reads its drives in turn.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use gelpad::pad::{Pad, shipped_pad};
use gelpad::source::board::{
    Board, BoardSettings, BoardSignal, CableFaults, ServePlan, ServeReport, serve,
};
use gelpad::source::{Script, Source, SourceReading};

#[allow(clippy::disallowed_methods, reason = "the board lives by the clock")]
pub fn now() -> Instant {
    Instant::now()
}

pub fn pad(name: &str) -> Pad {
    Pad::from_toml(name, shipped_pad(name).expect("shipped").toml).expect("sound")
}

/// A plan for a board that reads its drives in turn.
pub fn plan(frames_per_s: Option<f64>, baud: Option<u32>) -> ServePlan {
    ServePlan {
        link: None,
        frames_per_s,
        in_turn: true,
        baud,
        frames: None,
        faults: CableFaults::default(),
        other_board: None,
        seed: 1,
    }
}

/// A board that is served.
pub struct ServedBoard {
    pub port: String,
    /// When a host opened the port: the board's time starts there.
    pub opened: Arc<Mutex<Option<Instant>>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<ServeReport>>,
    _folder: tempfile::TempDir,
}

impl ServedBoard {
    pub fn start(
        pad: &Pad,
        settings: &BoardSettings,
        script: &str,
        (snr_db, seed): (f64, u64),
        plan: ServePlan,
    ) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let link: PathBuf = folder.path().join("port");
        let board = Board::new(pad, settings).expect("wired");
        let script = Script::parse("presses", script).expect("sound");
        let mut signal =
            BoardSignal::new(pad, &script, (snr_db, seed), 0.0, None).expect("solvable");
        let stop = Arc::new(AtomicBool::new(false));
        let opened = Arc::new(Mutex::new(None));
        let (stopping, opening) = (Arc::clone(&stop), Arc::clone(&opened));
        let plan = ServePlan {
            link: Some(link.clone()),
            ..plan
        };
        let thread = std::thread::Builder::new()
            .spawn(move || {
                let mut note = |message: &str| {
                    if message.starts_with("opened") {
                        *opening.lock().expect("unpoisoned") = Some(now());
                    }
                };
                serve(board, &mut signal, plan, &stopping, &mut note).expect("served")
            })
            .expect("a thread");
        while !link.exists() {
            std::thread::sleep(Duration::from_millis(2));
        }
        Self {
            port: link.display().to_string(),
            opened,
            stop,
            thread: Some(thread),
            _folder: folder,
        }
    }

    /// Ends the board; the port must have been closed.
    pub fn end(mut self) -> ServeReport {
        self.stop.store(true, Ordering::Relaxed);
        let thread = self.thread.take().expect("not ended before");
        thread.join().expect("no panic")
    }
}

impl Drop for ServedBoard {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// The next reading that is not idle, and when it came.
pub fn next(source: &mut dyn Source) -> (SourceReading, Instant) {
    let start = now();
    while start.elapsed() < Duration::from_secs(10) {
        match source.read().expect("fits the pad") {
            SourceReading::Idle => {}
            reading => return (reading, now()),
        }
    }
    panic!("the board is silent");
}
