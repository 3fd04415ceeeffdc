//! `gelpad accuracy --scan`: presses on a pad whose drives are read one after another.
//!
//! A board reads a frame drive by drive, so a press begins and ends within frames. Each session is played twice: its frames as
//! moments at their ends, and part by part ([`crate::touch::Scan`]). Counted are presses that are found, touches that nobody made, how late a
//! press and its end are seen, and the error of place.

mod play;
mod report;

pub use report::{ScanFindings, ScanRow};

use super::Bench;
use super::draws::Draws;
use super::specimen::Specimen;
use crate::study::{StudyError, job};
use play::{Played, Session};

/// Frame rates of the table, frames a second.
const RATES: [f64; 5] = [5.0, 10.0, 20.0, 50.0, 100.0];
/// Rate and speed of the slides, frames a second and mm/s.
const SLIDES: (f64, f64) = (100.0, 300.0);
/// White noise of the presses, dB.
const SNR_DB: f64 = 60.0;
/// An untouched pad is read at this rate, frames a second, with each of these noises, dB.
const REST: (f64, [f64; 2]) = (100.0, [60.0, 45.0]);

/// How much is played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScanExtent {
    /// Presses at each rate, on each pad.
    pub presses: usize,
    /// Slides, on each pad.
    pub slides: usize,
    /// Length of a session on an untouched pad, s.
    pub untouched_s: usize,
}

impl ScanExtent {
    /// Some minutes on two cores.
    pub const FULL: Self = Self {
        presses: 60,
        slides: 10,
        untouched_s: 600,
    };
    /// Some ten seconds.
    pub const QUICK: Self = Self {
        presses: 8,
        slides: 1,
        untouched_s: 20,
    };
}

/// What a row of the table plays.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Task {
    /// Presses at a frame rate.
    Presses(f64),
    /// Slides.
    Slides,
    /// No finger, with noise in dB.
    Rest(f64),
}

/// Plays everything on the pad as modelled and on one that differs from its model.
pub(super) fn play_all(
    bench: &Bench,
    extent: ScanExtent,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<ScanFindings, StudyError> {
    let mut draws = Draws::new(&bench.pad, bench.seed, 3000);
    let pads = [
        ("as modelled", Specimen::ideal(&bench.pad)?),
        ("realistic", Specimen::random(&bench.pad, &mut draws)?),
    ];
    let tasks: Vec<Task> = RATES
        .map(Task::Presses)
        .into_iter()
        .chain([Task::Slides])
        .chain(REST.1.map(Task::Rest))
        .collect();
    let runs: Vec<(usize, Task, bool)> = (0..pads.len())
        .flat_map(|pad| {
            tasks
                .iter()
                .flat_map(move |task| [false, true].map(|by_parts| (pad, *task, by_parts)))
        })
        .collect();
    let played: Vec<Played> = job::solve_in_parallel(
        &runs,
        |(pad, task, by_parts)| play(bench, &pads[*pad].1, *task, *by_parts, extent),
        progress,
    )?;
    let rows = runs
        .iter()
        .zip(&played)
        .map(|((pad, task, by_parts), played)| {
            let (what, rate) = match task {
                Task::Presses(rate) => ("presses".to_owned(), *rate),
                Task::Slides => (format!("slides at {} mm/s", SLIDES.1), SLIDES.0),
                Task::Rest(snr_db) => (format!("untouched, {snr_db} dB"), REST.0),
            };
            ScanRow::new(pads[*pad].0, &what, rate, *by_parts, played)
        });
    Ok(ScanFindings {
        seed: bench.seed,
        rows: rows.collect(),
    })
}

/// One session. Both ways of reading see the same fingers and the same noise.
fn play(
    bench: &Bench,
    specimen: &Specimen,
    task: Task,
    by_parts: bool,
    extent: ScanExtent,
) -> Result<Played, StudyError> {
    let (rate, snr_db) = match task {
        Task::Presses(rate) => (rate, SNR_DB),
        Task::Slides => (SLIDES.0, SNR_DB),
        Task::Rest(snr_db) => (REST.0, snr_db),
    };
    let mut draws = Draws::new(&bench.pad, bench.seed, 3100 + rate as u64);
    let mut session = Session::new(bench, specimen, rate, snr_db, by_parts);
    session.rest()?;
    match task {
        Task::Presses(_) => {
            for _ in 0..extent.presses {
                let press = draws.presses(1)?[0];
                session.press(&press, &mut draws)?;
            }
        }
        Task::Slides => {
            for _ in 0..extent.slides {
                let ends = draws.pair(60.0)?;
                session.slide(ends[0].centre_mm, ends[1].centre_mm, SLIDES.1)?;
            }
        }
        Task::Rest(_) => session.idle(extent.untouched_s as f64)?,
    }
    Ok(session.finish())
}
