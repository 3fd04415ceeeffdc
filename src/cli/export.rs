//! `gelpad export`: a recording as other programs read it. What was recorded, not what would come of it now.

use anyhow::{Context as _, bail};

use super::args::{ExportArgs, ExportFormat};
use super::exit::Ending;
use super::files::{self, Beside};
use super::play::say;
use super::replay;
use crate::engine::Input;
use crate::session::export::evemu::Recording;
use crate::session::export::fm2::Movie;
use crate::session::{ReadError, export::csv};
use crate::tape::{Played, PlayerError};
use crate::types::{Control, Frame};

pub(super) fn export(args: &ExportArgs) -> anyhow::Result<Ending> {
    match args.format {
        ExportFormat::Fm2 => movie(args),
        ExportFormat::Evemu => evemu(args),
        ExportFormat::Csv => frames(args),
    }
}

fn movie(args: &ExportArgs) -> anyhow::Result<Ending> {
    // The session begins with its first reading.
    let mut movie = None;
    let ending = each(args, |played| {
        match played {
            Played::Input(
                Input::Frame(Frame { t_ns, .. }) | Input::Control(Control { t_ns, .. }),
            ) => {
                movie.get_or_insert_with(|| Movie::new(*t_ns, args.start_frame));
            }
            Played::Event(event) => movie.iter_mut().for_each(|movie| movie.event(event)),
            _ => {}
        }
        Ok(())
    })?;
    let movie = movie.unwrap_or_else(|| Movie::new(0, args.start_frame));
    for (output, presses) in movie.strange() {
        say(&format!(
            "{output}, pressed {presses} times, is no button of a NES pad in fceux: left out"
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

fn evemu(args: &ExportArgs) -> anyhow::Result<Ending> {
    let mut recording = Recording::default();
    let ending = each(args, |played| {
        if let Played::Event(event) = played {
            recording.event(event);
        }
        Ok(())
    })?;
    files::write(&args.output, recording.to_evemu().as_bytes())?;
    Ok(ending)
}

fn frames(args: &ExportArgs) -> anyhow::Result<Ending> {
    let mut out = Beside::create(&args.output)?;
    let mut frames = 0u64;
    let ending = each(args, |played| {
        if let Played::Input(Input::Frame(frame)) = played {
            if frames == 0 {
                csv::header(&mut out, frame.volts.len())?;
            }
            frames += 1;
            csv::frame(&mut out, frame)?;
        }
        Ok(())
    })?;
    if frames == 0 {
        bail!("{}: there is no frame in it", args.file.display());
    }
    out.finish()?;
    Ok(ending)
}

/// All of a recording, in order.
fn each(
    args: &ExportArgs,
    mut take: impl FnMut(&Played) -> std::io::Result<()>,
) -> anyhow::Result<Ending> {
    if !replay::is_recording(&args.file)? {
        bail!(
            "{}: this is no recording\n  help: `gelpad play --record FILE.mcap` makes one",
            args.file.display()
        );
    }
    let (mut player, _) = replay::open(&args.file)?;
    let mut ending = Ending::Done;
    loop {
        match player.next() {
            Ok(Some(played)) => {
                if matches!(played, Played::Gap { .. }) {
                    ending = Ending::LostData;
                }
                take(&played)
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
