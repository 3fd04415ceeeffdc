//! Where what is replayed goes: lines on stdout, an output, an expectation; of a stretch of time, at its pace if wished.

use std::io::{BufWriter, Stdout, Write};
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::cli::args::{OutputArg, PrintArg, ReplayArgs, SourceArg};
use crate::cli::outputs;
use crate::cli::play::{Signals, say};
use crate::output::Held;
use crate::types::{Action, Event, Nanos, Output, Touch, ms_from_nanos};

/// What an output of text calls itself.
const TRACE: &str = "trace";
/// Longest sleep between two looks for a signal.
const NAP: Duration = Duration::from_millis(20);

/// Takes touches and events of a replay.
pub(super) struct Sink {
    stdout: BufWriter<Stdout>,
    print: Option<PrintArg>,
    device: Option<Held>,
    /// Outputs that are down on the device.
    down: Vec<Output>,
    /// Lines that are compared or saved.
    lines: Option<Vec<String>>,
    from_ns: Nanos,
    to_ns: Nanos,
    realtime: bool,
    start: Option<(Instant, Nanos)>,
    now_ns: Nanos,
    signals: Option<Signals>,
}

impl Sink {
    pub(super) fn new(args: &ReplayArgs) -> anyhow::Result<Self> {
        let device = match args.output {
            None => None,
            Some(OutputArg::Trace) => None,
            Some(output) => {
                let source = SourceArg::Replay(args.file.clone());
                let chosen = outputs::open(output, &source, true)?;
                if let Some(told) = &chosen.told {
                    say(told);
                }
                // Where there is nothing better than text, the lines on stdout are it.
                (chosen.device.name() != TRACE).then(|| Held::new(chosen.device))
            }
        };
        let judges = args.expect.is_some() || args.update.is_some();
        let quiet = judges || device.is_some();
        let ns = |seconds: f64| (seconds * 1e9) as Nanos;
        Ok(Self {
            stdout: BufWriter::new(std::io::stdout()),
            print: args.print.or((!quiet).then_some(PrintArg::Events)),
            // Ctrl-C must not leave a key down.
            signals: (device.is_some() || args.realtime)
                .then(Signals::listen)
                .transpose()?,
            device,
            down: Vec::new(),
            lines: judges.then(Vec::new),
            from_ns: args.from.map_or(0, ns),
            to_ns: args.to.map_or(Nanos::MAX, ns),
            realtime: args.realtime,
            start: None,
            now_ns: 0,
        })
    }

    /// Whether nothing more is wanted.
    pub(super) fn is_over(&self) -> bool {
        self.now_ns > self.to_ns || self.signal().is_some()
    }

    /// The signal that ended it, if one did.
    pub(super) fn signal(&self) -> Option<i32> {
        self.signals.as_ref().and_then(Signals::received)
    }

    /// The events so far, as lines.
    pub(super) fn lines(&self) -> &[String] {
        self.lines.as_deref().unwrap_or_default()
    }

    /// In real time, sleeps until a time of the source has come.
    pub(super) fn wait_until(&mut self, t_ns: Nanos) {
        self.now_ns = t_ns;
        if !self.realtime || t_ns < self.from_ns || t_ns > self.to_ns {
            return;
        }
        let (start, first_ns) = *self.start.get_or_insert_with(|| (now(), t_ns));
        let due = start + Duration::from_nanos(t_ns.saturating_sub(first_ns));
        // What is printed is seen when it happens.
        let _ = self.stdout.flush();
        while self.signal().is_none() {
            let left = due.saturating_duration_since(now());
            if left.is_zero() {
                return;
            }
            std::thread::sleep(left.min(NAP));
        }
    }

    /// The touches of a frame.
    pub(super) fn touches(&mut self, t_ns: Nanos, down: &[Touch]) -> anyhow::Result<()> {
        if self.print != Some(PrintArg::Touches) || !self.wants(t_ns) {
            return Ok(());
        }
        let line = TouchLine {
            t_ms: ms_from_nanos(t_ns),
            touches: down.iter().map(TouchEntry::of).collect(),
        };
        // As an IO error: a closed pipe is told from a failure by its kind.
        serde_json::to_writer(&mut self.stdout, &line).map_err(std::io::Error::from)?;
        self.stdout.write_all(b"\n")?;
        Ok(())
    }

    /// Events, as they come.
    pub(super) fn events(&mut self, events: &[Event]) -> anyhow::Result<()> {
        for event in events {
            if !self.wants(event.t_ns) {
                continue;
            }
            if self.print == Some(PrintArg::Events) {
                writeln!(self.stdout, "{event}")?;
            }
            if let Some(lines) = &mut self.lines {
                lines.push(event.to_string());
            }
            self.send(event)?;
        }
        if let Some(device) = self.device.as_mut().filter(|_| !events.is_empty()) {
            device.flush()?;
        }
        Ok(())
    }

    /// All is printed, and the keys come up.
    pub(super) fn finish(&mut self) -> anyhow::Result<()> {
        self.device = None;
        self.stdout.flush()?;
        Ok(())
    }

    fn wants(&self, t_ns: Nanos) -> bool {
        (self.from_ns..=self.to_ns).contains(&t_ns)
    }

    /// To the device; a release of what went down before the stretch is nothing to it.
    fn send(&mut self, event: &Event) -> anyhow::Result<()> {
        let Some(device) = &mut self.device else {
            return Ok(());
        };
        match event.action {
            Action::Press(output) => self.down.push(output),
            Action::Release(output) if !self.down.contains(&output) => return Ok(()),
            Action::Release(output) => self.down.retain(|down| *down != output),
            _ => {}
        }
        Ok(device.send(event)?)
    }
}

#[allow(
    clippy::disallowed_methods,
    reason = "the pace of a replay in real time"
)]
fn now() -> Instant {
    Instant::now()
}

/// A line of `--print touches`.
#[derive(Serialize)]
struct TouchLine {
    t_ms: f64,
    touches: Vec<TouchEntry>,
}

#[derive(Serialize)]
struct TouchEntry {
    id: u64,
    x_mm: f64,
    y_mm: f64,
    area_mm2: f64,
    force: f64,
}

impl TouchEntry {
    fn of(touch: &Touch) -> Self {
        let thousandths = |value: f64| (value * 1e3).round() / 1e3;
        let contact = &touch.contact;
        Self {
            id: touch.id.0,
            x_mm: thousandths(contact.centre_mm[0]),
            y_mm: thousandths(contact.centre_mm[1]),
            area_mm2: thousandths(contact.area_mm2),
            force: thousandths(contact.force),
        }
    }
}
