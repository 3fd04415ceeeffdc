//! Connects a simulated board to a pseudo-terminal and the clock.

use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::line::Outgoing;
use super::{Board, BoardSignal, CableFaults, FaultyCable, RepeatedFault};
use crate::platform::pseudo_terminal::Pty;
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
    /// Whether a frame is read drive after drive until the next one begins, as boards do; else at one moment. Only with a rate.
    pub in_turn: bool,
    /// Speed of the serial line, baud: ten bits a byte. None: bytes take no time.
    pub baud: Option<u32>,
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
        outgoing: Outgoing::new(None, now()),
        frame_bytes: 0,
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
    outgoing: Outgoing,
    /// Bytes of the last frame.
    frame_bytes: usize,
}

impl Server<'_> {
    fn is_over(&self) -> bool {
        let has_all = self
            .plan
            .frames
            .is_some_and(|frames| self.report.frames >= frames);
        (has_all && self.outgoing.is_empty()) || self.stop.load(Ordering::Relaxed)
    }

    /// Serves from the opening of the port to its closing; returns why it ended.
    fn session(&mut self, signal: &mut BoardSignal) -> io::Result<&'static str> {
        let start = now();
        let boot = self.board.reset();
        self.outgoing = Outgoing::new(self.plan.baud, start);
        self.send(&boot)?;
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
            let is_paused = pause.is_on(elapsed);
            if !is_paused && let Some(bytes) = self.outgoing.take_due(now()) {
                self.send(&bytes)?;
                continue;
            }
            let span = self.frame_span();
            let is_due = span.is_none() || now() >= due;
            let is_free = self.outgoing.is_empty() && !self.has_all_frames();
            if is_due && is_free && self.board.is_sending() && !is_paused {
                due = due.max(self.outgoing.busy_until());
                let from_us = match span {
                    Some(_) => due.duration_since(start).as_micros() as u64,
                    None => free_us,
                };
                free_us += FREE_STEP_US;
                self.begin_frame(signal, (due, from_us), span, between.is_on(elapsed));
            } else {
                let next = self.outgoing.next_due().filter(|_| !is_paused);
                let left = next.unwrap_or(due).saturating_duration_since(now());
                self.pty.wait(if left.is_zero() {
                    NAP / 10
                } else {
                    left.min(NAP)
                });
                if !self.pty.is_open() {
                    return Ok("closed");
                }
            }
            if let Some(span) = span
                && is_due
                && (is_free || is_paused)
            {
                due += span;
            }
        }
        Ok("done")
    }

    fn has_all_frames(&self) -> bool {
        self.plan
            .frames
            .is_some_and(|frames| self.report.frames >= frames)
    }

    /// Time from frame to frame: that of the rate, or that of the line if it is longer. None: as fast as the host reads.
    fn frame_span(&self) -> Option<Duration> {
        let line = self.outgoing.time_of(self.frame_bytes);
        let period = self
            .plan
            .frames_per_s
            .map(|rate| Duration::from_secs_f64(1.0 / rate));
        match period {
            Some(period) => Some(period.max(line)),
            None => (!line.is_zero()).then_some(line),
        }
    }

    /// Reads a frame that begins at a time, and queues its bytes.
    fn begin_frame(
        &mut self,
        signal: &mut BoardSignal,
        (due, from_us): (Instant, u64),
        span: Option<Duration>,
        is_between: bool,
    ) {
        let in_turn = span.filter(|_| self.plan.in_turn);
        let span = in_turn.unwrap_or_default();
        let to_us = from_us + span.as_micros() as u64;
        let volts = match in_turn {
            Some(_) => signal.read_in_turn(1000 * from_us, 1000 * to_us),
            None => signal.read(1000 * from_us),
        };
        let board = match &mut self.plan.other_board {
            Some((other, _)) if is_between => other,
            _ => &mut self.board,
        };
        self.frame_bytes = 0;
        for piece in board.frame_pieces(from_us, to_us, &volts) {
            self.frame_bytes += piece.bytes.len();
            let ready = piece.ready.map(|share| due + span.mul_f64(share));
            self.outgoing.add(self.cable.carry(piece.bytes), ready);
        }
        self.report.frames += 1;
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
