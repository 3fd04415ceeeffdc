//! `gelpad replay`: a recording or frames through the engine, as fast as it goes or in real time.
//!
//! A recording brings what its engine was made of and every input: played without other wishes it does to the bit
//! what was played then, and whether it did is checked against what was recorded. With another profile, pad or method its
//! frames are played anew.

mod ahead;
mod expect;
mod sink;
mod verify;

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::Arc;

use anyhow::Context as _;

use super::args::ReplayArgs;
use super::exit::Ending;
use super::resolve;
use crate::eit::REFERENCE_FRAMES;
use crate::engine::{Engine, Input};
use crate::pad::DEFAULT_PAD;
use crate::profile::DEFAULT_PROFILE;
use crate::session::ReadError;
use crate::source::{FileKind, Reading, file_kind, open_file};
use crate::tape::{Kit, Played, Player, PlayerError};
use crate::touch::SensingBuilder;
use crate::types::Event;
use ahead::Ahead;
use sink::Sink;
use verify::Verify;

pub(super) fn replay(args: &ReplayArgs) -> anyhow::Result<Ending> {
    let mut sink = Sink::new(args)?;
    let mut played = if is_recording(&args.file)? {
        recording(args, &mut sink)
    } else {
        frames(args, &mut sink)
    };
    // What was printed before a mistake is worth having.
    sink.finish()?;
    if let (Ok(_), Some(signal)) = (&played, sink.signal()) {
        return Ok(Ending::Signal(signal));
    }
    if played.is_ok() {
        played = expect::judge(args, sink.lines()).and(played);
    }
    if let Some(path) = &args.junit {
        expect::write_junit(path, args, &played)?;
    }
    played
}

/// Whether a file begins as recordings do.
pub(super) fn is_recording(path: &Path) -> anyhow::Result<bool> {
    Ok(file_kind(path)? == FileKind::Recording)
}

/// Opens a recording.
pub(super) fn open(path: &Path) -> anyhow::Result<(Player<BufReader<File>>, Kit)> {
    let file = File::open(path).with_context(|| path.display().to_string())?;
    Player::open(BufReader::new(file)).with_context(|| path.display().to_string())
}

/// Frames from a CSV file.
fn frames(args: &ReplayArgs, sink: &mut Sink) -> anyhow::Result<Ending> {
    let pad = resolve::pad(args.pad.as_deref().unwrap_or(DEFAULT_PAD))?;
    let profile = args.profile.as_deref().unwrap_or(DEFAULT_PROFILE);
    let profile = resolve::profile(profile, args.user.as_deref())?;
    let correction = resolve::correction(args.calibration.as_deref(), &pad)?;
    let mut source = open_file(&args.file, &pad)?;
    let method = resolve::method(args.method, &profile, &pad);
    let builder = resolve::sensing(&pad, method)?;
    let engine = Engine::new(&pad, Arc::new(builder.first()?), profile).corrected(correction);
    let mut play = Play::new(engine, Some(builder), sink);
    while !play.sink.is_over() {
        match source.read() {
            Ok(Reading::Frame(frame)) => play.input(&Input::Frame(frame))?,
            Ok(Reading::End) => break,
            Ok(
                Reading::Control(_)
                | Reading::Skipped { .. }
                | Reading::Gone { .. }
                | Reading::Idle,
            ) => {}
            Err(error) => {
                play.end()?;
                return Err(error.into());
            }
        }
    }
    play.end()?;
    play.was_long_enough(&args.file)?;
    Ok(Ending::Done)
}

/// A recording.
fn recording(args: &ReplayArgs, sink: &mut Sink) -> anyhow::Result<Ending> {
    let (player, kit) = open(&args.file)?;
    let anew = Anew::of(args);
    let (engine, builder) = anew.engine(args, &kit)?;
    let mut verify = anew.nothing().then(Verify::default);
    let mut play = Play::new(engine, builder, sink);
    let mut ahead = Ahead::start(player)?;
    let mut left_out = false;
    let outcome = loop {
        if play.sink.is_over() {
            break Ok(());
        }
        match ahead.next() {
            Ok(Some(Played::Input(input))) if anew.drops(&input) => {}
            Ok(Some(Played::Input(input))) => {
                play.input(&input)?;
                if let Some(verify) = &mut verify {
                    verify.replayed(&input, play.engine.touches().down, &play.events);
                }
            }
            Ok(Some(Played::Touches(touches))) => {
                verify.iter_mut().for_each(|v| v.recorded_touches(&touches))
            }
            Ok(Some(Played::Event(event))) => {
                verify.iter_mut().for_each(|v| v.recorded_event(&event))
            }
            Ok(Some(Played::Gap { inputs })) => {
                left_out = true;
                let many = if inputs == 0 {
                    "some".to_owned()
                } else {
                    inputs.to_string()
                };
                tracing::warn!(
                    "{many} inputs are missing in the recording from here on: what follows may differ from what was played"
                );
            }
            Ok(None) => break Ok(()),
            Err(error) => break Err(error),
        }
    };
    let is_over = play.sink.is_over();
    play.end()?;
    let cut = match outcome {
        Ok(()) => false,
        Err(PlayerError::Read(error @ ReadError::Cut { .. })) => {
            tracing::warn!("{}: {error}; all before it was played", args.file.display());
            true
        }
        Err(error) => return Err(error).with_context(|| args.file.display().to_string()),
    };
    if !is_over && !cut && !ahead.is_whole() {
        tracing::warn!(
            "{}: not closed (killed?): played up to its last whole message",
            args.file.display()
        );
    }
    if !is_over {
        play.was_long_enough(&args.file)?;
    }
    if let Some(verify) = verify.filter(|_| !left_out) {
        let is_expected = args.expect.as_deref() == Some(args.file.as_path());
        match verify.first_difference() {
            None => tracing::info!(
                "{}: replayed as it was recorded, to the bit",
                args.file.display()
            ),
            Some(difference) if is_expected => {
                anyhow::bail!(
                    "{}: not replayed as it was recorded: {difference}",
                    args.file.display()
                );
            }
            Some(difference) => tracing::warn!(
                "{}: not replayed as it was recorded: {difference}",
                args.file.display()
            ),
        }
    }
    Ok(if cut || left_out {
        Ending::LostData
    } else {
        Ending::Done
    })
}

/// What is wished to be other than in the recording.
struct Anew {
    profile: bool,
    /// Matrices are made here and now.
    matrix: bool,
    calibration: bool,
}

impl Anew {
    fn of(args: &ReplayArgs) -> Self {
        Self {
            profile: args.profile.is_some() || args.user.is_some(),
            matrix: args.pad.is_some() || args.method.is_some(),
            calibration: args.calibration.is_some(),
        }
    }

    fn nothing(&self) -> bool {
        !(self.profile || self.matrix || self.calibration)
    }

    /// Whether an input of the recording is of what is made anew. The profile's ticks go with it: the engine makes
    /// up for them at the next frame.
    fn drops(&self, input: &Input) -> bool {
        match input {
            Input::Profile { .. } | Input::Tick { .. } => self.profile,
            Input::Matrix(_) => self.matrix,
            _ => false,
        }
    }

    fn engine(
        &self,
        args: &ReplayArgs,
        kit: &Kit,
    ) -> anyhow::Result<(Engine, Option<SensingBuilder>)> {
        let mut kit = kit.clone();
        if let Some(pad) = &args.pad {
            let pad = resolve::pad(pad)?;
            if pad.channels() != kit.pad.channels() {
                let (wants, has) = (pad.channels(), kit.pad.channels());
                anyhow::bail!(
                    "the pad {} has {wants} voltages a frame, the recording {has}\n  help: leave out --pad: a recording brings its own",
                    pad.name
                );
            }
            kit.pad = pad;
        }
        if self.profile {
            kit.profile = match &args.profile {
                Some(profile) => resolve::profile(profile, args.user.as_deref())?,
                None => resolve::with_user(&kit.profile, args.user.as_deref())?,
            };
        }
        if let Some(file) = &args.calibration {
            kit.correction = resolve::correction(Some(file), &kit.pad)?;
        }
        if !self.matrix {
            return Ok((kit.engine(), None));
        }
        let method = resolve::method(args.method, &kit.profile, &kit.pad);
        let builder = match (&args.pad, &kit.table) {
            (None, Some(table)) => {
                SensingBuilder::new(&kit.pad, method)?.with_table(Arc::clone(table))
            }
            _ => resolve::sensing(&kit.pad, method)?,
        };
        kit.sensing = Arc::new(builder.first()?);
        Ok((kit.engine(), Some(builder)))
    }
}

/// An engine that is played.
struct Play<'a> {
    engine: Engine,
    /// Makes the matrices that the engine wishes for, where the recording does not bring them.
    builder: Option<SensingBuilder>,
    sink: &'a mut Sink,
    events: Vec<Event>,
    last_ns: u64,
    frames: usize,
    controls: usize,
}

impl<'a> Play<'a> {
    fn new(engine: Engine, builder: Option<SensingBuilder>, sink: &'a mut Sink) -> Self {
        Self {
            engine,
            builder,
            sink,
            events: Vec::new(),
            last_ns: 0,
            frames: 0,
            controls: 0,
        }
    }

    /// Takes an input; what came of it is in `events` until the next.
    fn input(&mut self, input: &Input) -> anyhow::Result<()> {
        self.events.clear();
        let t_ns = match input {
            Input::Frame(frame) => {
                self.frames += 1;
                Some(frame.t_ns)
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
        if let Input::Frame(frame) = input {
            self.sink.touches(frame.t_ns, self.engine.touches().down)?;
        }
        self.sink.events(&self.events)?;
        if let Some(builder) = &self.builder
            && let Some(deviations) = self.engine.wanted()
        {
            let sensing = Arc::new(builder.build(deviations)?);
            self.engine.input(&Input::Matrix(sensing), &mut self.events);
        }
        Ok(())
    }

    /// Whatever is held is released.
    fn end(&mut self) -> anyhow::Result<()> {
        let t_ns = self.last_ns;
        self.events.clear();
        self.engine.input(&Input::End { t_ns }, &mut self.events);
        let events = std::mem::take(&mut self.events);
        self.sink.events(&events)
    }

    /// Nothing can be told of a session that ends with its reference.
    fn was_long_enough(&self, file: &Path) -> anyhow::Result<()> {
        if self.controls == 0 && self.frames < REFERENCE_FRAMES {
            let frames = match self.frames {
                1 => "1 frame".to_owned(),
                frames => format!("{frames} frames"),
            };
            anyhow::bail!(
                "{}: only {frames}: the first {REFERENCE_FRAMES} are the reference, so no touch can be told",
                file.display()
            );
        }
        Ok(())
    }
}
