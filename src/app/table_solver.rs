//! Solves response tables on threads of low priority while a game is already played from images.
//!
//! A table is solved once, however many games of its pad are started meanwhile. It reaches the engine as a matrix, an input like
//! any other, between two touches.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use crate::cache;
use crate::eit::{ResponseBuilder, ResponseTable};
use crate::pad::Pad;
use crate::runtime::{self, PlayCommand, RunningGame};

/// How often a start that needs the table asks whether it is solved.
const POLL: Duration = Duration::from_millis(20);

/// A table that is being solved.
#[derive(Debug, Default)]
pub struct TableInProgress {
    done_rows: AtomicUsize,
    rows: AtomicUsize,
    /// The table; none inside if the pad cannot be solved.
    solved: OnceLock<Option<Arc<ResponseTable>>>,
}

impl TableInProgress {
    /// The solved share, 0 to 1.
    #[must_use]
    pub fn share(&self) -> f32 {
        let rows = self.rows.load(Ordering::Relaxed).max(1);
        self.done_rows.load(Ordering::Relaxed) as f32 / rows as f32
    }

    /// Whether it has ended.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.solved.get().is_some()
    }

    /// The table, once it is solved.
    #[must_use]
    pub fn table(&self) -> Option<Arc<ResponseTable>> {
        self.solved.get()?.clone()
    }

    /// Sends a game the table that it was started without, once that is solved; returns whether it did. `table` is none from then on,
    /// or once solving has failed; it stays while the engine is too busy for the command.
    pub fn hand_over(table: &mut Option<Arc<Self>>, running: &mut RunningGame) -> bool {
        let Some(solved) = table.as_ref().and_then(|table| table.solved.get()) else {
            return false;
        };
        let is_sent = solved
            .clone()
            .is_some_and(|solved| running.send_command(PlayCommand::Table(solved)));
        if is_sent || solved.is_none() {
            *table = None;
        }
        is_sent
    }

    fn report(&self, done_rows: usize, rows: usize) {
        self.rows.store(rows, Ordering::Relaxed);
        self.done_rows.fetch_max(done_rows, Ordering::Relaxed);
    }
}

/// A table that a game is about to use.
pub(super) enum TableStart {
    /// It was in the cache.
    Ready(Arc<ResponseTable>),
    /// It is being solved.
    Solving(Arc<TableInProgress>),
}

/// The tables that are being solved.
#[derive(Debug, Default)]
pub(crate) struct TableSolver {
    /// With the key of the pad.
    running: Mutex<Vec<(String, Arc<TableInProgress>)>>,
}

impl TableSolver {
    /// The table of a pad from the cache; starts to solve it if it is not there.
    pub(super) fn start(&self, pad: &Pad) -> std::io::Result<TableStart> {
        let key = ResponseBuilder::key(pad);
        let mut running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        running.retain(|(_, table)| !table.has_ended());
        if let Some((_, table)) = running.iter().find(|(known, _)| *known == key) {
            return Ok(TableStart::Solving(Arc::clone(table)));
        }
        if let Some(table) = cache::folder().and_then(|folder| cache::load(pad, &folder)) {
            return Ok(TableStart::Ready(Arc::new(table)));
        }
        let table = Arc::new(TableInProgress::default());
        let (pad, solving) = (pad.clone(), Arc::clone(&table));
        std::thread::Builder::new()
            .name("table".to_owned())
            .spawn(move || {
                let solved = solve(&pad, &solving);
                let _ = solving.solved.set(solved);
            })?;
        running.push((key, Arc::clone(&table)));
        Ok(TableStart::Solving(table))
    }

    /// Waits until the table of a pad is solved, if it is being solved: it is in the cache then.
    pub(super) fn wait(&self, pad: &Pad) {
        let key = ResponseBuilder::key(pad);
        let running = self.running.lock().unwrap_or_else(PoisonError::into_inner);
        let table = running.iter().find(|(known, _)| *known == key);
        let table = table.map(|(_, table)| Arc::clone(table));
        drop(running);
        while table.as_ref().is_some_and(|table| !table.has_ended()) {
            std::thread::sleep(POLL);
        }
    }
}

/// Threads that play does not notice.
pub(super) fn low_priority_threads() -> Result<rayon::ThreadPool, rayon::ThreadPoolBuildError> {
    rayon::ThreadPoolBuilder::new()
        .thread_name(|index| format!("table-{index}"))
        .start_handler(|_| runtime::lower_priority())
        .build()
}

/// Solves a table on its own threads; none if that fails, which images do not depend on.
fn solve(pad: &Pad, progress: &TableInProgress) -> Option<Arc<ResponseTable>> {
    let solved = low_priority_threads()
        .map_err(|error| error.to_string())
        .and_then(|threads| {
            threads.install(|| {
                cache::load_or_solve(pad, &|done, rows| progress.report(done, rows))
                    .map_err(|error| error.to_string())
            })
        });
    solved
        .inspect_err(|error| tracing::warn!("the table of {} is not solved: {error}", pad.name))
        .ok()
        .map(Arc::new)
}
