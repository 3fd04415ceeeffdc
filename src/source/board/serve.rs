//! Connects a simulated board to a pseudo-terminal and the clock.

use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::{Board, BoardSignal, CableFaults, FaultyCable, Pty, RepeatedFault};
use crate::source::SIMULATED_FRAME_NS;
use crate::source::clock::now;

/// Longest sleep, and so the longest delay of a stop.
const NAP: Duration = Duration::from_millis(10);
/// Board time between two frames when no rate is set, us.
const FREE_STEP_US: u64 = SIMULATED_FRAME_NS / 1000;

/// How a board is served.
pub struct ServePlan {
    /// Path of the port; none: chosen by the system.
    pub link: Option<PathBuf>,
    /// Frames a second; none: as many as the host reads.
    pub frames_per_s: Option<f64>,
    /// Number of frames after which serving ends; none: when it is stopped.
    pub frames: Option<u64>,
    /// Faults of the cable.
    pub faults: CableFaults,
    /// A board of another format that replaces the first from time to time.
    pub other_board: Option<(Board, RepeatedFault)>,
    /// Seed of the faults.
    pub seed: u64,
}

/// Counts of a served board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ServeReport {
    /// Frames sent, including damaged ones.
    pub frames: u64,
    /// Bytes sent.
    pub bytes: u64,
    /// Bytes lost by the cable.
    pub lost_bytes: u64,
    /// Bits flipped by the cable.
    pub turned_bits: u64,
    /// How often a host opened the port.
    pub opened: u64,
    /// How often the port disappeared.
    pub hang_ups: u64,
}

/// Serves a board until it is stopped or has sent all its frames. `on_message` receives the port's path and every
/// change of state.
///
/// # Errors
/// There is no pseudo-terminal left, or an error of the terminal.
pub fn serve(
    board: Board,
    signal: &mut BoardSignal,
    plan: ServePlan,
    stop: &AtomicBool,
    on_message: &mut dyn FnMut(&str),
) -> io::Result<ServeReport> {
    let mut server = Server {
        pty: Pty::open(plan.link.as_deref())?,
        cable: FaultyCable::new(plan.faults, plan.seed),
        report: ServeReport::default(),
        board,
        plan,
        stop,
    };
    on_message(&format!("port {}", server.pty.path().display()));
    while !server.is_over() {
        if server.pty.is_open() {
            on_message("opened: the board starts");
            server.report.opened += 1;
            let why = server.session(signal)?;
            on_message(why);
        } else {
            std::thread::sleep(NAP);
        }
    }
    let (lost_bytes, turned_bits) = server.cable.damage();
    // The host reads what was sent before the port disappears.
    server.drain();
    Ok(ServeReport {
        lost_bytes,
        turned_bits,
        ..server.report
    })
}

struct Server<'a> {
    pty: Pty,
    cable: FaultyCable,
    report: ServeReport,
    board: Board,
    plan: ServePlan,
    stop: &'a AtomicBool,
}

impl Server<'_> {
    fn is_over(&self) -> bool {
        let has_all = self
            .plan
            .frames
            .is_some_and(|frames| self.report.frames >= frames);
        has_all || self.stop.load(Ordering::Relaxed)
    }

    /// Serves from the opening of the port to its closing; returns why it ended.
    fn session(&mut self, signal: &mut BoardSignal) -> io::Result<&'static str> {
        let start = now();
        let boot = self.board.reset();
        self.send(&boot)?;
        let period = self
            .plan
            .frames_per_s
            .map(|rate| Duration::from_secs_f64(1.0 / rate));
        let mut due = start;
        let mut free_us = 0;
        let pause = FaultTimer(self.plan.faults.pause);
        let hang_up = FaultTimer(self.plan.faults.hang_up);
        let between = FaultTimer(self.plan.other_board.as_ref().map(|(_, every)| *every));
        let mut received = [0; 512];
        while !self.is_over() {
            let elapsed = start.elapsed();
            let count = self.pty.read(&mut received)?;
            if count > 0 {
                let answer = self.board.receive(&received[..count]);
                self.send(&answer)?;
            }
            if hang_up.is_on(elapsed) {
                self.hang_up()?;
                return Ok("hung up");
            }
            if self.report.frames.is_multiple_of(16) && !self.pty.is_open() {
                return Ok("closed");
            }
            let is_due = period.is_none() || now() >= due;
            if is_due && self.board.is_sending() && !pause.is_on(elapsed) {
                let time_us = match period {
                    Some(_) => due.duration_since(start).as_micros() as u64,
                    None => free_us,
                };
                free_us += FREE_STEP_US;
                self.frame(signal, time_us, between.is_on(elapsed))?;
            } else {
                let left = due.saturating_duration_since(now());
                self.pty.wait(if left.is_zero() {
                    NAP / 10
                } else {
                    left.min(NAP)
                });
                if !self.pty.is_open() {
                    return Ok("closed");
                }
            }
            if let Some(period) = period
                && is_due
            {
                due += period;
            }
        }
        Ok("done")
    }

    fn frame(
        &mut self,
        signal: &mut BoardSignal,
        time_us: u64,
        is_between: bool,
    ) -> io::Result<()> {
        let volts = signal.read(1000 * time_us);
        let board = match &mut self.plan.other_board {
            Some((other, _)) if is_between => other,
            _ => &mut self.board,
        };
        let bytes = self.cable.carry(board.frame(time_us, &volts));
        self.report.frames += 1;
        self.send(&bytes)
    }

    /// Sends all bytes; waits for room as long as a host has the port open.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut left = bytes;
        while !left.is_empty() && !self.stop.load(Ordering::Relaxed) {
            let sent = self.pty.write(left)?;
            if sent == 0 && !self.pty.is_open() {
                break;
            }
            left = &left[sent..];
            self.report.bytes += sent as u64;
        }
        Ok(())
    }

    fn hang_up(&mut self) -> io::Result<()> {
        self.report.hang_ups += 1;
        let away = self.plan.faults.hang_up.map_or(NAP, |every| every.length);
        let link = self.plan.link.clone();
        // The old end and its link are removed first: for a while there is no port.
        if let Some(link) = &link {
            let _ = std::fs::remove_file(link);
        }
        let fresh = Pty::open(None)?;
        drop(std::mem::replace(&mut self.pty, fresh));
        let until = now() + away;
        while now() < until && !self.stop.load(Ordering::Relaxed) {
            std::thread::sleep(NAP.min(away));
        }
        self.pty = Pty::open(link.as_deref())?;
        Ok(())
    }

    /// Waits until the host has closed the port, at most for a second.
    fn drain(&mut self) {
        let until = now() + Duration::from_secs(1);
        while self.pty.is_open() && now() < until {
            std::thread::sleep(NAP);
        }
    }
}

/// A repeated fault in time.
struct FaultTimer(Option<RepeatedFault>);

impl FaultTimer {
    fn is_on(&self, elapsed: Duration) -> bool {
        self.0.is_some_and(|RepeatedFault { period, length }| {
            let [elapsed, period, length] = [elapsed, period, length].map(|time| time.as_micros());
            elapsed >= period && (elapsed - period) % (period + length) < length
        })
    }
}
