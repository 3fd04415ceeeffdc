//! `gelpad export`: converts a recording for other programs. Events are those that were recorded; nothing is replayed.

use anyhow::{Context as _, bail};

use super::args::{ExportArgs, ExportFormat};
use super::exit::Ending;
use super::message::say;
use crate::app::recording::{is_recording, open_recording};
use crate::engine::Input;
use crate::files::{self, OutputFile};
use crate::session::export::evemu::EvemuRecording;
use crate::session::export::fm2::Fm2Movie;
use crate::session::{ReadError, export::csv};
use crate::tape::{PlayerError, RecordedItem};
use crate::types::{Control, Frame, FrameAssembler, Part};

pub(super) fn export(args: &ExportArgs) -> anyhow::Result<Ending> {
    files::refuse_input(&args.file, &args.output)?;
    match args.format {
        ExportFormat::Fm2 => export_movie(args),
        ExportFormat::Evemu => export_evemu(args),
        ExportFormat::Csv => export_frames(args),
    }
}

fn export_movie(args: &ExportArgs) -> anyhow::Result<Ending> {
    // The session starts with its first frame or control.
    let mut movie = None;
    let ending = for_each(args, |played, _| {
        match played {
            RecordedItem::Input(
                Input::Frame(Frame { t_ns, .. })
                | Input::Part(Part { t_ns, .. })
                | Input::Control(Control { t_ns, .. }),
            ) => {
                movie.get_or_insert_with(|| Fm2Movie::new(*t_ns, args.start_frame));
            }
            RecordedItem::Event(event) => movie.iter_mut().for_each(|movie| movie.add_event(event)),
            _ => {}
        }
        Ok(())
    })?;
    let movie = movie.unwrap_or_else(|| Fm2Movie::new(0, args.start_frame));
    for (output, presses) in movie.unmapped_outputs() {
        say(&format!(
            "left out {presses} presses of {output}: no button of the NES controller in FCEUX"
        ));
    }
    files::write(&args.output, movie.to_fm2(&args.rom).as_bytes())?;
    say(&format!(
        "{}: {} frames of the game",
        args.output.display(),
        movie.frames().len()
    ));
    Ok(ending)
}

fn export_evemu(args: &ExportArgs) -> anyhow::Result<Ending> {
    let mut recording = EvemuRecording::default();
    let ending = for_each(args, |played, _| {
        if let RecordedItem::Event(event) = played {
            recording.add_event(event);
        }
        Ok(())
    })?;
    files::write(&args.output, recording.to_evemu().as_bytes())?;
    Ok(ending)
}

fn export_frames(args: &ExportArgs) -> anyhow::Result<Ending> {
    let mut out = OutputFile::create(&args.output)?;
    let mut frames = 0u64;
    let mut assembler = FrameAssembler::default();
    let ending = for_each(args, |played, channels| {
        let assembled;
        let frame = match played {
            RecordedItem::Input(Input::Frame(frame)) => Some(frame),
            RecordedItem::Input(Input::Part(part)) => {
                assembled = assembler.add(part, channels);
                assembled.as_ref()
            }
            _ => None,
        };
        if let Some(frame) = frame {
            if frames == 0 {
                csv::write_header(&mut out, frame.volts.len())?;
            }
            frames += 1;
            csv::write_frame(&mut out, frame)?;
        }
        Ok(())
    })?;
    if frames == 0 {
        bail!("{}: contains no frame", args.file.display());
    }
    out.finish()?;
    Ok(ending)
}

/// Calls `write` with everything in a recording, in order, and the number of the pad's channels.
fn for_each(
    args: &ExportArgs,
    mut write: impl FnMut(&RecordedItem, usize) -> std::io::Result<()>,
) -> anyhow::Result<Ending> {
    if !is_recording(&args.file)? {
        bail!(
            "{}: not a recording\n  help: `gelpad play --record FILE.mcap` makes one",
            args.file.display()
        );
    }
    let (mut player, config) = open_recording(&args.file)?;
    let channels = config.pad.channels();
    let mut ending = Ending::Done;
    loop {
        match player.next() {
            Ok(Some(played)) => {
                if matches!(played, RecordedItem::Gap { .. }) {
                    ending = Ending::LostData;
                }
                write(&played, channels)
                    .with_context(|| format!("{} cannot be written", args.output.display()))?;
            }
            Ok(None) => return Ok(ending),
            Err(PlayerError::Read(error @ ReadError::Cut { .. })) => {
                say(&format!("{}: {error}", args.file.display()));
                return Ok(Ending::LostData);
            }
            Err(error) => return Err(error).with_context(|| args.file.display().to_string()),
        }
    }
}
