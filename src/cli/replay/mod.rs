//! `gelpad replay`: plays a recording or frames from a file, as fast as possible or in real time.
//!
//! A recording contains its engine's configuration and every input. Replayed without overrides, it gives bit-identical
//! events, which is checked against the recorded ones. With another profile, pad, method or calibration its frames are
//! played through a new engine.

mod expect;
mod overrides;
mod player;
mod sink;
mod verify;

use std::path::Path;
use std::sync::Arc;

use anyhow::Context as _;

use super::args::ReplayArgs;
use super::exit::Ending;
use super::progress::solve_pad;
use crate::app::ReadAhead;
use crate::app::calibration::pad_and_calibration;
use crate::app::pads::{choose_method, load_pad};
use crate::app::recording::{is_recording, open_recording};
use crate::engine::{Engine, Input};
use crate::files;
use crate::pad::DEFAULT_PAD;
use crate::profile::DEFAULT_PROFILE;
use crate::session::ReadError;
use crate::source::{PartSplitter, SourceReading, open_file};
use crate::tape::{PlayerError, RecordedItem};
use overrides::{ReplayOverrides, load_correction, load_profile_and_warn};
use player::EnginePlayer;
use sink::Sink;
use verify::Verify;

pub(super) fn replay(args: &ReplayArgs) -> anyhow::Result<Ending> {
    let (pad, calibration) = pad_and_calibration(args.pad.clone(), args.calibration.clone());
    let args = &ReplayArgs {
        pad,
        calibration,
        ..args.clone()
    };
    for output in args.update.iter().chain(&args.junit) {
        files::refuse_input(&args.file, output)?;
    }
    let mut sink = Sink::new(args)?;
    let mut played = if is_recording(&args.file)? {
        anyhow::ensure!(
            !args.scan,
            "{}: --scan is for files of frames: a recording replays as it was read",
            args.file.display()
        );
        replay_recording(args, &mut sink)
    } else {
        replay_frames(args, &mut sink)
    };
    // Events before an error are printed too.
    sink.finish()?;
    if let (Ok(_), Some(signal)) = (&played, sink.signal()) {
        return Ok(Ending::Signal(signal));
    }
    if played.is_ok() {
        played = expect::save_or_compare(args, sink.lines()).and(played);
    }
    if let Some(path) = &args.junit {
        expect::write_junit(path, args, &played)?;
    }
    played
}

/// Plays frames from a file.
fn replay_frames(args: &ReplayArgs, sink: &mut Sink) -> anyhow::Result<Ending> {
    let pad = load_pad(args.pad.as_deref().unwrap_or(DEFAULT_PAD))?.pad;
    let profile = args.profile.as_deref().unwrap_or(DEFAULT_PROFILE);
    let profile = load_profile_and_warn(profile, args.user.as_deref())?;
    let correction = load_correction(args.calibration.as_deref(), &pad)?;
    let mut source = open_file(&args.file, &pad)?;
    let builder = solve_pad(&pad, choose_method(args.method, &profile, &pad))?;
    let engine =
        Engine::new(&pad, Arc::new(builder.build_initial()?), profile).with_correction(correction);
    let mut player = EnginePlayer::new(engine, Some(builder), sink);
    let mut splitter = args.scan.then(|| PartSplitter::new(&pad.protocol));
    while !player.sink.is_over() {
        match source.read() {
            Ok(SourceReading::Frame(frame)) => match &mut splitter {
                Some(splitter) => player.parts(splitter.take(frame))?,
                None => player.input(&Input::Frame(frame))?,
            },
            Ok(SourceReading::End) => break,
            Ok(_) => {}
            Err(error) => {
                player.end()?;
                return Err(error.into());
            }
        }
    }
    if let Some(splitter) = &mut splitter {
        player.parts(splitter.finish())?;
    }
    player.end()?;
    player.check_length(&args.file)?;
    Ok(Ending::Done)
}

/// Plays a recording.
fn replay_recording(args: &ReplayArgs, sink: &mut Sink) -> anyhow::Result<Ending> {
    let (recorded, config) = open_recording(&args.file)?;
    let overrides = ReplayOverrides::from_args(args);
    let (engine, builder) = overrides.engine(args, &config)?;
    let mut verify = overrides.is_empty().then(Verify::default);
    let mut player = EnginePlayer::new(engine, builder, sink);
    let mut messages = ReadAhead::start(recorded)?;
    let mut has_gaps = false;
    let outcome = loop {
        if player.sink.is_over() {
            break Ok(());
        }
        match messages.next() {
            Ok(Some(RecordedItem::Gap { inputs })) => {
                has_gaps = true;
                warn_of_gap(inputs);
            }
            Ok(Some(played)) => step(&played, &overrides, &mut player, verify.as_mut())?,
            Ok(None) => break Ok(()),
            Err(error) => break Err(error),
        }
    };
    let is_over = player.sink.is_over();
    player.end()?;
    let is_cut = check_end(outcome, &args.file)?;
    if !is_over {
        if !is_cut && !messages.is_whole() {
            tracing::warn!(
                "{}: not closed, perhaps killed: played up to the last complete message",
                args.file.display()
            );
        }
        player.check_length(&args.file)?;
    }
    if let Some(verify) = verify.filter(|_| !has_gaps) {
        report_verification(&verify, args)?;
    }
    Ok(if is_cut || has_gaps {
        Ending::LostData
    } else {
        Ending::Done
    })
}

/// Plays one message of a recording.
fn step(
    played: &RecordedItem,
    overrides: &ReplayOverrides,
    player: &mut EnginePlayer<'_>,
    verify: Option<&mut Verify>,
) -> anyhow::Result<()> {
    match (played, verify) {
        (RecordedItem::Input(input), verify) if !overrides.replaces(input) => {
            player.input(input)?;
            if let Some(verify) = verify {
                verify.add_replayed(input, player.engine.touches_down(), &player.events);
            }
        }
        (RecordedItem::Touches(touches), Some(verify)) => verify.add_recorded_touches(touches),
        (RecordedItem::Event(event), Some(verify)) => verify.add_recorded_event(event),
        _ => {}
    }
    Ok(())
}

fn warn_of_gap(inputs: u64) {
    let count = match inputs {
        0 => "some".to_owned(),
        inputs => inputs.to_string(),
    };
    tracing::warn!(
        "{count} inputs are missing in the recording: from here on the replay may differ from what was played"
    );
}

/// Whether a recording ended within a message.
fn check_end(outcome: Result<(), PlayerError>, file: &Path) -> anyhow::Result<bool> {
    match outcome {
        Ok(()) => Ok(false),
        Err(PlayerError::Read(error @ ReadError::Cut { .. })) => {
            tracing::warn!("{}: {error}; played everything before it", file.display());
            Ok(true)
        }
        Err(error) => Err(error).with_context(|| file.display().to_string()),
    }
}

/// Reports whether the replay gave the recorded events; a difference is an error if `--expect` names the recording.
fn report_verification(verify: &Verify, args: &ReplayArgs) -> anyhow::Result<()> {
    let name = args.file.display();
    match verify.first_difference() {
        None => tracing::info!("{name}: replayed bit for bit as recorded"),
        Some(difference) if args.expect.as_deref() == Some(args.file.as_path()) => {
            anyhow::bail!("{name}: not replayed as recorded: {difference}");
        }
        Some(difference) => tracing::warn!("{name}: not replayed as recorded: {difference}"),
    }
    Ok(())
}
