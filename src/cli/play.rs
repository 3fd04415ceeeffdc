//! `gelpad play`, and the level that plays without arguments.

use std::io::IsTerminal as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::Context as _;
use hdrhistogram::Histogram;
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};

use super::args::{PlayArgs, SourceArg};
use super::changes::Changes;
use super::exit::{self, Ending};
use super::gamepads::{self, Opened};
use super::live::{LiveView, Title, Wish};
use super::outputs::{self, Chosen, Takes};
use super::pick::Picker;
use super::played_with::{Asides, PlayedWith};
use super::resolve;
use crate::engine::Engine;
use crate::output::{Device, OutputError};
use crate::pad::{DEFAULT_PAD, Pad};
use crate::profile::{DEFAULT_PROFILE, Profile};
use crate::runtime::{self, Command, Running, Stages, Summary};
use crate::source::serial::SerialSource;
use crate::source::{LEVEL_SCRIPT, Noise, Script, SimulatedSource, Source, SourceError, open_file};
use crate::tape::Kit;
use crate::touch::{Correction, SensingBuilder};
use crate::types::Method;

/// A press that lasts so many frames is seen, at any rate of frames (`tests/lattice_session.rs`).
const SURE_FRAMES: f64 = 2.0;
/// How often signals are looked at, and the live view drawn.
const LOOK: Duration = Duration::from_millis(33);
/// Noise of the level, dB, and its seed.
const LEVEL_NOISE: (f64, u64) = (60.0, 1);

/// The main job without arguments: the level on the simulated pad; nothing reaches the desktop.
pub(super) fn level() -> anyhow::Result<Ending> {
    let pad = resolve::pad(DEFAULT_PAD)?;
    let profile = resolve::profile(DEFAULT_PROFILE, None)?;
    let script = Script::parse("level", LEVEL_SCRIPT)?;
    let noise = Noise::new(LEVEL_NOISE.0, LEVEL_NOISE.1);
    let source = SimulatedSource::new(&pad, &script, noise)?;
    let live = can_show();
    let device = outputs::trace(live);
    let title = Title {
        source: "simulated pad, the level".to_owned(),
        output: "nothing leaves this terminal".to_owned(),
    };
    let (builder, kit) = kit(pad, String::new(), profile, Method::default(), None)?;
    let title = live.then_some(title);
    let (made, asides) = ((kit.engine(), builder), Asides::default());
    run(
        &kit.pad,
        made,
        Box::new(source),
        device,
        title,
        None,
        asides,
    )
}

/// Whether there is a terminal that can be drawn on.
fn can_show() -> bool {
    std::io::stdout().is_terminal() && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// `gelpad play`.
pub(super) fn play(args: &PlayArgs) -> anyhow::Result<Ending> {
    let PlayedWith {
        pad,
        pad_toml,
        checked,
        argument,
        correction,
    } = PlayedWith::of(args)?;
    checked.warnings.iter().for_each(exit::warn);
    let profile = Arc::new(checked.profile.clone());
    if args.source == SourceArg::Gamepad && profile.parts.is_empty() {
        anyhow::bail!(
            "the profile {} is not played by a gamepad: none of its bindings has a `from`\n  help: write `from = \"pad:a\"` in a binding, or try the profile super-mario-gamepad",
            profile.name
        );
    }
    let live = !args.headless && can_show();
    let source = source(args, &pad)?;
    let Chosen { device, told } = outputs::open(args.output, &args.source, live)?;
    if let Some(told) = told {
        say(&told);
    }
    let source = source(device.is_gamepad());
    let takes = Takes::of(device.as_ref());
    if let Some(lacking) = takes.lacking(&profile) {
        anyhow::bail!("{lacking}");
    }
    // A profile out of a recording lies nowhere where it could be saved anew.
    let changes = argument.map(|argument| {
        let picker = args.follow.then(|| Picker::new(&argument));
        let refuse = Box::new(move |profile: &Profile| takes.lacking(profile));
        Changes::new(&argument, args.user.as_deref(), &checked, picker, refuse)
    });
    let title = Title {
        source: match &args.source {
            SourceArg::Simulated(None) => "simulated pad, the level".to_owned(),
            SourceArg::Simulated(Some(script)) => format!("simulated pad, {}", script.display()),
            SourceArg::Serial(port) => port.clone(),
            SourceArg::Replay(file) => file.display().to_string(),
            SourceArg::Gamepad => "gamepad".to_owned(),
        },
        output: device.name().to_owned(),
    };
    let method = resolve::method(args.method, &profile, &pad);
    let title = live.then_some(title);
    let (builder, kit) = kit(pad, pad_toml, profile, method, correction)?;
    let asides = Asides::start(args, &kit)?;
    let made = (kit.engine(), builder);
    run(&kit.pad, made, source, device, title, changes, asides)
}

pub(super) fn source(args: &PlayArgs, pad: &Pad) -> anyhow::Result<Opened> {
    let source: Box<dyn Source> = match &args.source {
        SourceArg::Gamepad => return gamepads::open(),
        SourceArg::Simulated(script_path) => {
            let script = match script_path {
                Some(path) => Script::parse(&path.display().to_string(), &resolve::read(path)?)?,
                None => Script::parse("level", LEVEL_SCRIPT)?,
            };
            let is_level = script_path.is_none();
            let noise = Noise::new(args.snr, args.seed);
            let source = SimulatedSource::new(pad, &script, noise);
            if is_level && matches!(source, Err(SourceError::OffPad { .. })) {
                anyhow::bail!(
                    "the built-in level does not fit the pad {}\n  help: give a script of your own: --source simulated:FILE",
                    pad.name
                );
            }
            Box::new(source?)
        }
        SourceArg::Serial(port) => Box::new(SerialSource::open(
            port,
            args.board.baud,
            pad,
            args.board.format,
        )?),
        SourceArg::Replay(file) => open_file(file, pad)?,
    };
    Ok(Box::new(|_| source))
}

/// What an engine is made of, and what remakes its matrices.
pub(super) fn kit(
    pad: Pad,
    pad_toml: String,
    profile: Arc<Profile>,
    method: Method,
    correction: Option<Correction>,
) -> anyhow::Result<(SensingBuilder, Kit)> {
    let builder = resolve::sensing(&pad, method)?;
    let sensing = Arc::new(builder.first()?);
    let locating = sensing.locating.as_ref();
    let kit = Kit {
        table: locating.map(|locating| Arc::clone(locating.table())),
        pad,
        pad_toml,
        profile,
        correction,
        sensing,
    };
    Ok((builder, kit))
}

/// Plays until the source ends or a signal comes; shows it if a title is given.
fn run(
    pad: &Pad,
    (engine, builder): (Engine, SensingBuilder),
    source: Box<dyn Source>,
    device: Box<dyn Device>,
    title: Option<Title>,
    changes: Option<Changes>,
    asides: Asides,
) -> anyhow::Result<Ending> {
    let mut view = match title {
        Some(title) => Some(LiveView::open(title, pad)?),
        None => None,
    };
    // Until here nothing is held: Ctrl-C may end the program as it likes.
    let signals = Signals::listen()?;
    let Asides {
        listeners,
        recorder,
    } = asides;
    let mut running = runtime::start_with(engine, builder, source, device, listeners)
        .context("no thread to play on")?;
    let watched = watch(&mut running, &signals, view.as_mut(), changes);
    running.stop();
    let summary = running.join();
    drop(view);
    let ending = conclude(summary, watched?);
    match recorder.map(|recorder| recorder.conclude()) {
        // What was lost matters less than why it ended.
        Some(Ending::LostData) if matches!(ending, Ok(Ending::Done)) => Ok(Ending::LostData),
        _ => ending,
    }
}

/// Draws and waits; returns the signal that ended it, if one did.
fn watch(
    running: &mut Running,
    signals: &Signals,
    mut view: Option<&mut LiveView>,
    mut changes: Option<Changes>,
) -> anyhow::Result<Option<i32>> {
    while !running.is_finished() {
        if let Some(signal) = signals.received() {
            return Ok(Some(signal));
        }
        if let Some(changes) = &mut changes {
            changes.look(running, &mut |text| match view.as_deref_mut() {
                Some(view) => view.tell(in_one_line(text)),
                None => say(text.trim_end()),
            });
        }
        match view.as_deref_mut() {
            // A raw terminal gives Ctrl-C as a key.
            Some(view) => match view.draw_and_wait(running.view(), LOOK)? {
                Wish::GoOn => {}
                Wish::End => return Ok(None),
                Wish::Interrupt => return Ok(Some(SIGINT)),
                Wish::Pause => {
                    running.ask(Command::Pause);
                }
                Wish::Rezero => {
                    running.ask(Command::Rezero);
                }
            },
            None => std::thread::sleep(LOOK),
        }
    }
    Ok(signals.received())
}

/// What a text for the terminal says first, without its colours.
pub(super) fn in_one_line(text: &str) -> String {
    let mut plain = String::new();
    let mut is_colour = false;
    for character in text.chars() {
        match character {
            '\u{1b}' => is_colour = true,
            'm' if is_colour => is_colour = false,
            _ if is_colour => {}
            '×' => {}
            _ => plain.push(character),
        }
    }
    let first = plain.lines().find(|line| !line.trim().is_empty());
    let words: Vec<&str> = first.unwrap_or_default().split_whitespace().collect();
    words.join(" ")
}

/// Says how it went, and how it ended.
fn conclude(summary: Summary, signal: Option<i32>) -> anyhow::Result<Ending> {
    say(&told(&summary));
    if let Some(thread) = summary.panicked {
        anyhow::bail!("a bug in gelpad ended its {thread} thread; all keys are up");
    }
    match summary.output_error {
        Some(OutputError::Closed) => return Ok(Ending::Done),
        Some(error) => return Err(error.into()),
        None => {}
    }
    if let Some(error) = summary.source_error {
        return Err(error.into());
    }
    Ok(match signal {
        Some(signal) => Ending::Signal(signal),
        None if summary.lost_frames > 0 => Ending::LostData,
        None => Ending::Done,
    })
}

/// A line for the player; a closed stderr is no reason to stop.
pub(super) fn say(text: &str) {
    use std::io::Write as _;

    let _ = writeln!(std::io::stderr(), "{text}");
}

fn told(summary: &Summary) -> String {
    let mut text = format!(
        "{}, {}",
        counted(summary.frames, "frame"),
        counted(summary.presses, "press")
    );
    if summary.lost_frames > 0 {
        text.push_str(&format!(
            ", {} lost ({} of them garbled)",
            counted(summary.lost_frames, "frame"),
            summary.skipped
        ));
    }
    if summary.frames_per_s > 0.0 {
        text.push_str(&format!(
            ", {:.0} frames/s: a press of {:.0} ms and more is sure to be seen",
            summary.frames_per_s,
            SURE_FRAMES * 1e3 / summary.frames_per_s
        ));
    }
    let times = |histogram: &Histogram<u64>| {
        let us = |quantile| histogram.value_at_quantile(quantile) as f64 / 1000.0;
        format!("median {:.0} us, p99 {:.0} us", us(0.5), us(0.99))
    };
    if summary.frames > 0 {
        text.push_str(&format!(
            "\nframe to events: {}",
            times(&summary.frame_to_events_ns)
        ));
    }
    if summary.presses > 0 {
        text.push_str(&format!(
            "\nframe to device: {}",
            times(&summary.frame_to_device_ns)
        ));
        text.push_str(&format!("\n{}", by_stage(&summary.stages)));
    }
    if summary.late_events > 0 {
        text.push_str(&format!(
            "\n{} of {} went out late, the latest by {:.0} ms: is the computer busy?",
            summary.late_events,
            counted(summary.events, "event"),
            summary.latest.as_secs_f64() * 1e3
        ));
    }
    text
}

/// Median and p99 of every stage, us.
fn by_stage(stages: &Stages) -> String {
    let parts = [
        ("queue", stages.queue),
        ("touches", stages.touches),
        ("events", stages.events),
        ("device", stages.device),
    ];
    let parts = parts
        .map(|(name, spread)| format!("{name} {:.0} / {:.0} us", spread.median_us, spread.p99_us));
    format!("by stage, median / p99: {}", parts.join(", "))
}

fn counted(count: u64, what: &str) -> String {
    match (count, what) {
        (1, _) => format!("1 {what}"),
        (_, "press") => format!("{count} presses"),
        _ => format!("{count} {what}s"),
    }
}

/// What ends a game from outside. A second one of any kind ends the program at once, in case an output hangs.
const ENDINGS: [i32; 4] = [SIGINT, SIGTERM, SIGHUP, SIGQUIT];

/// Signals as flags.
pub(super) struct Signals {
    received: [Arc<AtomicBool>; ENDINGS.len()],
}

impl Signals {
    pub(super) fn listen() -> anyhow::Result<Self> {
        let any = Arc::new(AtomicBool::new(false));
        let received = ENDINGS.map(|_| Arc::new(AtomicBool::new(false)));
        for (signal, flag) in ENDINGS.into_iter().zip(&received) {
            signal_hook::flag::register_conditional_shutdown(
                signal,
                128 + signal,
                Arc::clone(&any),
            )
            .and_then(|_| signal_hook::flag::register(signal, Arc::clone(&any)))
            .and_then(|_| signal_hook::flag::register(signal, Arc::clone(flag)))
            .with_context(|| format!("signal {signal} cannot be caught"))?;
        }
        Ok(Self { received })
    }

    pub(super) fn received(&self) -> Option<i32> {
        let index = self
            .received
            .iter()
            .position(|flag| flag.load(Ordering::Relaxed))?;
        Some(ENDINGS[index])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drawn_mistake_is_told_in_one_plain_line() {
        let drawn = "the old profile stays:   \u{1b}[31m×\u{1b}[0m ./live.toml:105:8: `drect` is no mode\n  more";
        assert_eq!(
            in_one_line(drawn),
            "the old profile stays: ./live.toml:105:8: `drect` is no mode"
        );
    }
}
