//! Opens sources.

use std::path::Path;

use super::gamepads::{self, OpenSource};
use super::request::{BoardLine, NoiseLevel, SourceChoice};
use super::texts::read_text;
use super::{AppError, services::PlayRequest};
use crate::pad::Pad;
use crate::source::serial::SerialSource;
use crate::source::{
    DisturbedSource, LiveFingers, LiveSource, Noise, RoundedSource, Script, SimulatedSource,
    Source, open_file,
};

/// Opens the source of a request; the simulated pad that the window presses comes with its [`LiveFingers`].
pub(super) fn open_requested(
    request: &PlayRequest,
    pad: &Pad,
) -> Result<(OpenSource, Option<LiveFingers>), AppError> {
    match &request.source {
        SourceChoice::Gamepad => Ok((gamepads::open()?, None)),
        SourceChoice::Simulated => {
            let (source, hand) = LiveSource::new(pad, noise(request.noise))?;
            let source = disturbed(Box::new(source), request, pad);
            Ok((Box::new(|_| source), Some(hand)))
        }
        SourceChoice::Level | SourceChoice::Script(_) if request.in_turn_hz.is_some() => {
            let script = match &request.source {
                SourceChoice::Script(path) => load_script(Some(path), pad)?,
                _ => load_script(None, pad)?,
            };
            let source = SimulatedSource::new(pad, &script, noise(request.noise))?
                .in_turn(pad, request.in_turn_hz.unwrap_or_default());
            Ok((Box::new(|_| Box::new(source)), None))
        }
        choice => {
            let source = open_pad_source(choice, request.board, request.noise, pad)?;
            let mut source = disturbed(source, request, pad);
            source.read_in_parts();
            Ok((Box::new(|_| source), None))
        }
    }
}

/// The source with the disturbances of the request, rounded for a slim recording.
fn disturbed(source: Box<dyn Source>, request: &PlayRequest, pad: &Pad) -> Box<dyn Source> {
    let source = if request.disturbances.is_empty() {
        source
    } else {
        let list = request.disturbances.clone();
        let seed = request.noise.seed;
        Box::new(DisturbedSource::new(source, list, &pad.protocol, seed))
    };
    match request.slim {
        true => Box::new(RoundedSource::new(source)),
        false => source,
    }
}

/// Opens a source of frames.
pub(crate) fn open_pad_source(
    choice: &SourceChoice,
    board: BoardLine,
    level: NoiseLevel,
    pad: &Pad,
) -> Result<Box<dyn Source>, AppError> {
    Ok(match choice {
        SourceChoice::Level => {
            let script = load_script(None, pad)?;
            Box::new(SimulatedSource::new(pad, &script, noise(level))?)
        }
        SourceChoice::Script(path) => {
            let script = load_script(Some(path), pad)?;
            Box::new(SimulatedSource::new(pad, &script, noise(level))?)
        }
        SourceChoice::Serial(port) => {
            Box::new(SerialSource::open(port, board.baud, pad, board.format)?)
        }
        SourceChoice::Replay(file) => open_file(file, pad)?,
        SourceChoice::Simulated | SourceChoice::Gamepad => {
            return Err(AppError::Unsuitable(
                "this source has no frames that can be read here".to_owned(),
            ));
        }
    })
}

/// The simulated pad with nothing on it for ten minutes: a script needs a finger, so one follows.
pub(crate) fn untouched_pad(pad: &Pad, level: NoiseLevel) -> Result<Box<dyn Source>, AppError> {
    let [x_mm, y_mm] = pad.outline.size_mm().map(|side| side / 2.0);
    let late = format!("t:600000 down 1 {x_mm} {y_mm}\nt:600100 up 1");
    let rest = Script::parse("untouched", &late)?;
    Ok(Box::new(SimulatedSource::new(pad, &rest, noise(level))?))
}

/// A touch script from a file, or the built-in level on this pad.
pub(crate) fn load_script(path: Option<&Path>, pad: &Pad) -> Result<Script, AppError> {
    Ok(match path {
        Some(path) => Script::parse(&path.display().to_string(), &read_text(path)?)?,
        None => Script::level(pad.outline.size_mm())?,
    })
}

fn noise(level: NoiseLevel) -> Noise {
    Noise::new(level.snr_db, level.seed)
}
