//! `gelpad pad identify`: the pad as it is, from its readings at rest and, if there are any, from presses.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::bail;

use super::args::IdentifyArgs;
use super::exit::Ending;
use super::guided_presses::{Outcome, PressSource, check_files, record_guided};
use super::progress::Spinner;
use crate::app::calibration::load_presses;
use crate::app::identify::{FoundPad, describe, identify_pad, read_frames};
use crate::app::pads::load_drawn_pad;
use crate::app::services::{NoiseLevel, SourceChoice};
use crate::app::source::{open_pad_source, untouched_pad};
use crate::app::texts::as_pad_argument;
use crate::files;
use crate::pad::Pad;
use crate::study::figure::ConductanceMap;
use crate::types::printable;

pub(super) fn run(args: &IdentifyArgs) -> anyhow::Result<Ending> {
    for path in args.output.iter().chain(&args.map) {
        check_new(path, args)?;
    }
    if args.source == SourceChoice::Gamepad {
        bail!("a gamepad cannot be identified as a pad: give serial:PORT or replay:FILE");
    }
    let drawing = load_drawn_pad(&args.pad)?;
    let level = NoiseLevel {
        snr_db: args.snr,
        seed: args.seed,
    };
    let (untouched, presses, recording) = match args.points {
        Some(count) => match record(args, &drawing.pad, level, count)? {
            Outcome::Signal(signal) => return Ok(Ending::Signal(signal)),
            Outcome::Pressed(pressed) => (
                pressed.untouched,
                Some(pressed.presses),
                Some((pressed.signals, pressed.is_complete)),
            ),
        },
        None => {
            let presses = args.presses.as_deref().map(load_presses).transpose()?;
            (read_untouched(args, &drawing.pad, level)?, presses, None)
        }
    };
    let spinner = Spinner::new();
    spinner.show("looking for the pad that has these readings");
    let found = identify_pad(&drawing, &untouched, presses.as_ref())?;
    drop(spinner);
    if let Some(signal) = recording
        .as_ref()
        .and_then(|(signals, _)| signals.received())
    {
        return Ok(Ending::Signal(signal));
    }
    let mut stdout = std::io::stdout().lock();
    writeln!(stdout, "{}", printable(&describe(&found)))?;
    if let Some(path) = &args.output {
        files::write(path, found.toml.as_bytes())?;
        writeln!(
            std::io::stderr(),
            "written: {}; play with it: --pad {}",
            path.display(),
            as_pad_argument(path)
        )?;
    }
    if let Some(path) = &args.map {
        files::write(path, &map(&found, path)?)?;
    }
    Ok(match recording {
        Some((_, false)) => Ending::LostData,
        _ => Ending::Done,
    })
}

fn read_untouched(
    args: &IdentifyArgs,
    drawing: &Pad,
    level: NoiseLevel,
) -> anyhow::Result<Vec<Vec<f32>>> {
    let mut source = match &args.source {
        SourceChoice::Level => untouched_pad(drawing, level)?,
        choice => open_pad_source(choice, args.board.line(), level, drawing)?,
    };
    source.require_frames();
    Ok(read_frames(source.as_mut(), args.frames as usize)?)
}

/// Records presses at shown places, and what the pad reads between them.
fn record(
    args: &IdentifyArgs,
    drawing: &Pad,
    level: NoiseLevel,
    count: usize,
) -> anyhow::Result<Outcome> {
    let file = args.presses.as_deref();
    let outputs: Vec<&Path> = args
        .output
        .iter()
        .chain(&args.map)
        .map(PathBuf::as_path)
        .collect();
    check_files(file, &outputs)?;
    let source = PressSource {
        choice: &args.source,
        board: args.board.line(),
        noise: level,
    };
    record_guided(drawing, source, count, None, file)
}

/// Refuses to overwrite the drawing, or a file that is there.
fn check_new(path: &Path, args: &IdentifyArgs) -> anyhow::Result<()> {
    files::refuse_input(Path::new(&args.pad), path)?;
    if path.is_file() {
        bail!(
            "{} exists: it would be overwritten\n  help: name another file, or remove it",
            path.display()
        );
    }
    Ok(())
}

fn map(found: &FoundPad, path: &Path) -> anyhow::Result<Vec<u8>> {
    let pad = &found.found.pad;
    let figure = ConductanceMap {
        name: "found".to_owned(),
        title: format!("{} as found", pad.name),
        pads: vec![("conductance of the layer".to_owned(), pad.clone())],
    }
    .draw()?;
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("svg") => Ok(figure.svg.into_bytes()),
        Some("png") => Ok(figure.png),
        _ => bail!(
            "--map {}: name a file that ends in .png or .svg",
            path.display()
        ),
    }
}
