//! Gives a simulated board a pseudo-terminal and the time.

use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::{Board, Cable, Every, Faults, Pty, Signal};

/// Longest sleep: what stopping waits for.
const NAP: Duration = Duration::from_millis(10);
/// Without a rate, the pad's time goes on by so much a frame.
const FREE_STEP_US: u64 = 10_000;

/// What is to be done.
pub struct Plan {
    /// Where the host finds the port; none: where the system puts it.
    pub link: Option<PathBuf>,
    /// Frames a second; none: as many as the host takes.
    pub frames_per_s: Option<f64>,
    /// Frames after which it ends; none: when it is stopped.
    pub frames: Option<u64>,
    /// What goes wrong.
    pub faults: Faults,
    /// A board of another format that speaks in between.
    pub between: Option<(Board, Every)>,
    /// Seed of the faults.
    pub seed: u64,
}

/// What was done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Served {
    /// Frames sent, damaged ones too.
    pub frames: u64,
    /// Bytes sent.
    pub bytes: u64,
    /// Bytes that the cable lost.
    pub lost_bytes: u64,
    /// Bits that the cable turned.
    pub turned_bits: u64,
    /// How often a host opened the port.
    pub opened: u64,
    /// How often the port went away.
    pub hang_ups: u64,
}

/// Serves a board until it is stopped or has sent all its frames. `tell` is told where the port is, and what happens.
///
/// # Errors
/// No pseudo-terminal, or the terminal's.
pub fn serve(
    board: Board,
    signal: &mut Signal,
    plan: Plan,
    stop: &AtomicBool,
    tell: &mut dyn FnMut(&str),
) -> io::Result<Served> {
    let mut server = Server {
        pty: Pty::open(plan.link.as_deref())?,
        cable: Cable::new(plan.faults, plan.seed),
        served: Served::default(),
        board,
        plan,
        stop,
    };
    tell(&format!("port {}", server.pty.path().display()));
    while !server.is_over() {
        if server.pty.is_open() {
            tell("opened: the board starts");
            server.served.opened += 1;
            let why = server.session(signal)?;
            tell(why);
        } else {
            std::thread::sleep(NAP);
        }
    }
    let (lost_bytes, turned_bits) = server.cable.damage();
    // What is on its way is read before the port goes away.
    server.drain();
    Ok(Served {
        lost_bytes,
        turned_bits,
        ..server.served
    })
}

struct Server<'a> {
    pty: Pty,
    cable: Cable,
    served: Served,
    board: Board,
    plan: Plan,
    stop: &'a AtomicBool,
}

impl Server<'_> {
    fn is_over(&self) -> bool {
        let has_all = self
            .plan
            .frames
            .is_some_and(|frames| self.served.frames >= frames);
        has_all || self.stop.load(Ordering::Relaxed)
    }

    /// From the opening of the port to its closing; says why it ended.
    fn session(&mut self, signal: &mut Signal) -> io::Result<&'static str> {
        let start = now();
        let boot = self.board.reset();
        self.send(&boot)?;
        let period = self
            .plan
            .frames_per_s
            .map(|rate| Duration::from_secs_f64(1.0 / rate));
        let mut due = start;
        let mut free_us = 0;
        let pause = Turn(self.plan.faults.pause);
        let hang_up = Turn(self.plan.faults.hang_up);
        let between = Turn(self.plan.between.as_ref().map(|(_, every)| *every));
        let mut heard = [0; 512];
        while !self.is_over() {
            let elapsed = start.elapsed();
            let count = self.pty.read(&mut heard)?;
            if count > 0 {
                let answer = self.board.hear(&heard[..count]);
                self.send(&answer)?;
            }
            if hang_up.is_on(elapsed) {
                self.hang_up()?;
                return Ok("hung up");
            }
            if self.served.frames.is_multiple_of(16) && !self.pty.is_open() {
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

    fn frame(&mut self, signal: &mut Signal, time_us: u64, is_between: bool) -> io::Result<()> {
        let volts = signal.read(1000 * time_us);
        let board = match &mut self.plan.between {
            Some((other, _)) if is_between => other,
            _ => &mut self.board,
        };
        let bytes = self.cable.carry(board.frame(time_us, &volts));
        self.served.frames += 1;
        self.send(&bytes)
    }

    /// Sends all, waiting for room as long as someone reads.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut left = bytes;
        while !left.is_empty() && !self.stop.load(Ordering::Relaxed) {
            let sent = self.pty.write(left)?;
            if sent == 0 && !self.pty.is_open() {
                break;
            }
            left = &left[sent..];
            self.served.bytes += sent as u64;
        }
        Ok(())
    }

    fn hang_up(&mut self) -> io::Result<()> {
        self.served.hang_ups += 1;
        let away = self.plan.faults.hang_up.map_or(NAP, |every| every.lasts);
        let link = self.plan.link.clone();
        // The old end is closed first, its link with it: for a while there is no port.
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

    /// Waits until the host has read what was sent, a second at most.
    fn drain(&mut self) {
        let until = now() + Duration::from_secs(1);
        while self.pty.is_open() && now() < until {
            std::thread::sleep(NAP);
        }
    }
}

/// Whether something that happens again and again happens now.
struct Turn(Option<Every>);

impl Turn {
    fn is_on(&self, elapsed: Duration) -> bool {
        self.0.is_some_and(|Every { every, lasts }| {
            let [elapsed, every, lasts] = [elapsed, every, lasts].map(|time| time.as_micros());
            elapsed >= every && (elapsed - every) % (every + lasts) < lasts
        })
    }
}

#[allow(clippy::disallowed_methods, reason = "a board sends at its own pace")]
fn now() -> Instant {
    Instant::now()
}
