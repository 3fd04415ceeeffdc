//! Where a replay goes: lines on stdout, an output, a comparison. Limited to a range of time, in real time if requested.

use std::io::{BufWriter, Stdout, Write};
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::app::outputs;
use crate::cli::args::{OutputArg, PrintArg, ReplayArgs};
use crate::cli::message::say;
use crate::output::ReleaseOnDrop;
use crate::platform::signals::Signals;
use crate::types::{Action, Event, Nanos, Output, Touch, ms_from_nanos};

/// Name of the text output.
const TRACE: &str = "trace";
/// Longest sleep between two checks for a signal.
const MAX_SLEEP: Duration = Duration::from_millis(20);

/// Receives touches and events of a replay.
pub(super) struct Sink {
    stdout: BufWriter<Stdout>,
    print: Option<PrintArg>,
    device: Option<ReleaseOnDrop>,
    /// Outputs that are down on the device.
    down: Vec<Output>,
    /// Events as lines, to compare or save.
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
            None | Some(OutputArg::Trace) => None,
            Some(output) => {
                let chosen = outputs::open(output.into(), false)?;
                if let Some(note) = &chosen.note {
                    say(note);
                }
                // Text is printed as the lines on stdout already.
                (chosen.device.name() != TRACE).then(|| ReleaseOnDrop::new(chosen.device))
            }
        };
        let keeps_lines = args.expect.is_some() || args.update.is_some();
        let is_quiet = keeps_lines || device.is_some();
        let ns = |seconds: f64| (seconds * 1e9) as Nanos;
        Ok(Self {
            stdout: BufWriter::new(std::io::stdout()),
            print: args.print.or((!is_quiet).then_some(PrintArg::Events)),
            // Ctrl-C must not leave a key down.
            signals: (device.is_some() || args.realtime)
                .then(Signals::listen)
                .transpose()?,
            device,
            down: Vec::new(),
            lines: keeps_lines.then(Vec::new),
            from_ns: args.from.map_or(0, ns),
            to_ns: args.to.map_or(Nanos::MAX, ns),
            realtime: args.realtime,
            start: None,
            now_ns: 0,
        })
    }

    /// Whether the range of time has ended, or a signal was received.
    pub(super) fn is_over(&self) -> bool {
        self.now_ns > self.to_ns || self.signal().is_some()
    }

    /// The received signal, if there is one.
    pub(super) fn signal(&self) -> Option<i32> {
        self.signals.as_ref().and_then(Signals::received)
    }

    /// The events so far, as lines.
    pub(super) fn lines(&self) -> &[String] {
        self.lines.as_deref().unwrap_or_default()
    }

    /// In real time, sleeps until a time of the source.
    pub(super) fn wait_until(&mut self, t_ns: Nanos) {
        self.now_ns = t_ns;
        if !self.realtime || t_ns < self.from_ns || t_ns > self.to_ns {
            return;
        }
        let (start, first_ns) = *self.start.get_or_insert_with(|| (now(), t_ns));
        let due = start + Duration::from_nanos(t_ns.saturating_sub(first_ns));
        // Lines appear at their time.
        let _ = self.stdout.flush();
        while self.signal().is_none() {
            let left = due.saturating_duration_since(now());
            if left.is_zero() {
                return;
            }
            std::thread::sleep(left.min(MAX_SLEEP));
        }
    }

    /// Prints the touches of a frame.
    pub(super) fn print_touches(&mut self, t_ns: Nanos, down: &[Touch]) -> anyhow::Result<()> {
        if self.print != Some(PrintArg::Touches) || !self.includes(t_ns) {
            return Ok(());
        }
        let line = TouchLine {
            t_ms: ms_from_nanos(t_ns),
            touches: down.iter().map(TouchEntry::from_touch).collect(),
        };
        // As an IO error: a closed pipe is recognised by its kind.
        serde_json::to_writer(&mut self.stdout, &line).map_err(std::io::Error::from)?;
        self.stdout.write_all(b"\n")?;
        Ok(())
    }

    /// Prints, keeps and sends events.
    pub(super) fn send_events(&mut self, events: &[Event]) -> anyhow::Result<()> {
        for event in events {
            if !self.includes(event.t_ns) {
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

    /// Flushes stdout and releases all keys.
    pub(super) fn finish(&mut self) -> anyhow::Result<()> {
        self.device = None;
        self.stdout.flush()?;
        Ok(())
    }

    fn includes(&self, t_ns: Nanos) -> bool {
        (self.from_ns..=self.to_ns).contains(&t_ns)
    }

    /// Sends an event to the output, except a release whose press was before the range.
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
    reason = "a replay in real time follows the clock"
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
    fn from_touch(touch: &Touch) -> Self {
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
