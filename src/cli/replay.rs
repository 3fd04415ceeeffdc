//! `gelpad replay`: recorded frames through the engine, as fast as it goes.

use std::io::{BufWriter, Write};
use std::sync::Arc;

use serde::Serialize;

use super::args::{PrintArg, ReplayArgs};
use super::exit::Ending;
use super::resolve;
use crate::engine::{Engine, Input};
use crate::source::{Reading, open_file};
use crate::types::{Event, Frame, Touch, ms_from_nanos};

pub(super) fn replay(args: &ReplayArgs) -> anyhow::Result<Ending> {
    let pad = resolve::pad(&args.pad)?;
    let profile = resolve::profile(&args.profile, args.user.as_deref())?;
    let correction = resolve::correction(args.calibration.as_deref(), &pad)?;
    let mut source = open_file(&args.file, &pad)?;
    let method = resolve::method(args.method, &profile, &pad);
    let builder = resolve::sensing(&pad, method)?;
    let mut engine = Engine::new(&pad, Arc::new(builder.first()?), profile).corrected(correction);
    let mut stdout = BufWriter::new(std::io::stdout().lock());
    let mut events = Vec::new();
    let mut last_ns = 0;
    // What was printed before a bad line is worth having: it is flushed before the error is told.
    let outcome = loop {
        match source.read() {
            Ok(Reading::Frame(frame)) => {
                last_ns = frame.t_ns;
                step(&mut engine, frame, args.print, &mut events, &mut stdout)?;
                if let Some(deviations) = engine.wanted() {
                    let sensing = Arc::new(builder.build(deviations)?);
                    engine.input(&Input::Matrix(sensing), &mut events);
                }
            }
            Ok(Reading::End) => break Ok(Ending::Done),
            Ok(Reading::Skipped { .. } | Reading::Gone { .. } | Reading::Idle) => {}
            Err(error) => break Err(error.into()),
        }
    };
    engine.input(&Input::End { t_ns: last_ns }, &mut events);
    print_events(args.print, &mut events, &mut stdout)?;
    stdout.flush()?;
    outcome
}

fn step(
    engine: &mut Engine,
    frame: Frame,
    print: PrintArg,
    events: &mut Vec<Event>,
    stdout: &mut impl Write,
) -> anyhow::Result<()> {
    let t_ns = frame.t_ns;
    engine.input(&Input::Frame(frame), events);
    if print == PrintArg::Touches {
        let line = TouchLine {
            t_ms: ms_from_nanos(t_ns),
            touches: engine.touches().down.iter().map(TouchEntry::of).collect(),
        };
        // As an IO error: a closed pipe is told from a failure by its kind.
        serde_json::to_writer(&mut *stdout, &line).map_err(std::io::Error::from)?;
        stdout.write_all(b"\n")?;
    }
    print_events(print, events, stdout)
}

fn print_events(
    print: PrintArg,
    events: &mut Vec<Event>,
    stdout: &mut impl Write,
) -> anyhow::Result<()> {
    for event in events.drain(..) {
        if print == PrintArg::Events {
            writeln!(stdout, "{event}")?;
        }
    }
    Ok(())
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
