//! Plays inputs through an engine into a sink.

use std::path::Path;
use std::sync::Arc;

use super::sink::Sink;
use crate::eit::REFERENCE_FRAMES;
use crate::engine::{Engine, Input};
use crate::touch::SensingBuilder;
use crate::types::{Event, Part};

/// An engine whose events go to a sink.
pub(super) struct EnginePlayer<'a> {
    pub engine: Engine,
    pub sink: &'a mut Sink,
    /// Events of the last input.
    pub events: Vec<Event>,
    /// Builds the matrices that the engine asks for, if the recording does not contain them.
    builder: Option<SensingBuilder>,
    last_ns: u64,
    frames: usize,
    controls: usize,
    /// How often it was reported that the board was plugged in another way.
    renumberings: u64,
}

impl<'a> EnginePlayer<'a> {
    pub(super) fn new(engine: Engine, builder: Option<SensingBuilder>, sink: &'a mut Sink) -> Self {
        Self {
            engine,
            sink,
            events: Vec::new(),
            builder,
            last_ns: 0,
            frames: 0,
            controls: 0,
            renumberings: 0,
        }
    }

    /// Plays an input; its events stay in `events` until the next input.
    pub(super) fn input(&mut self, input: &Input) -> anyhow::Result<()> {
        self.events.clear();
        let t_ns = match input {
            Input::Frame(frame) => {
                self.frames += 1;
                Some(frame.t_ns)
            }
            Input::Part(part) => {
                self.frames += usize::from(part.first == 0);
                Some(part.t_ns)
            }
            Input::Control(control) => {
                self.controls += 1;
                Some(control.t_ns)
            }
            Input::Tick { due_ns: t_ns }
            | Input::Profile { t_ns, .. }
            | Input::Pause { t_ns }
            | Input::Rezero { t_ns }
            | Input::End { t_ns } => Some(*t_ns),
            Input::Matrix(_) | Input::Lost { .. } => None,
        };
        self.last_ns = self.last_ns.max(t_ns.unwrap_or(0));
        self.sink.wait_until(self.last_ns);
        self.engine.input(input, &mut self.events);
        let read_ns = match input {
            Input::Frame(frame) => Some(frame.t_ns),
            Input::Part(part) => Some(part.t_ns),
            _ => None,
        };
        if let Some(t_ns) = read_ns {
            self.sink.print_touches(t_ns, self.engine.touches_down())?;
            self.report_numbering();
        }
        self.sink.send_events(&self.events)?;
        if let Some(builder) = &self.builder
            && let Some(deviations) = self.engine.wanted()
        {
            let sensing = Arc::new(builder.build(deviations)?);
            self.engine.input(&Input::Matrix(sensing), &mut self.events);
        }
        Ok(())
    }

    /// Plays the parts of frames.
    pub(super) fn parts(&mut self, parts: Vec<Part>) -> anyhow::Result<()> {
        for part in parts {
            self.input(&Input::Part(part))?;
        }
        Ok(())
    }

    fn report_numbering(&mut self) {
        let (numbering, renumberings) = self.engine.board_numbering();
        if renumberings > self.renumberings {
            self.renumberings = renumberings;
            tracing::warn!(
                "at {:.2} s the board was plugged in another way: it now counts {numbering}; touches stay in the pad's places",
                self.last_ns as f64 * 1e-9
            );
        }
    }

    /// Releases everything that is held.
    pub(super) fn end(&mut self) -> anyhow::Result<()> {
        let t_ns = self.last_ns;
        self.events.clear();
        self.engine.input(&Input::End { t_ns }, &mut self.events);
        self.sink.send_events(&self.events)
    }

    /// A session that is shorter than its reference contains no touch.
    pub(super) fn check_length(&self, file: &Path) -> anyhow::Result<()> {
        if self.controls == 0 && self.frames < REFERENCE_FRAMES {
            let frames = match self.frames {
                1 => "1 frame".to_owned(),
                frames => format!("{frames} frames"),
            };
            anyhow::bail!(
                "{}: only {frames}: the first {REFERENCE_FRAMES} are the reference, so no touch can be detected",
                file.display()
            );
        }
        Ok(())
    }
}
