//! Presses at shown places, from a board, a file or a robot: opens the source, records, and keeps what was pressed in a file.

use std::path::Path;
use std::sync::Arc;

use anyhow::bail;

use super::message::say;
use super::progress::solve_pad;
use super::record_presses::{Presser, record};
use crate::app::places::calibration_places;
use crate::app::services::{BoardLine, NoiseLevel, SourceChoice};
use crate::app::source::open_pad_source;
use crate::calibrate::{FEWEST_PRESSES, GuidedReadings, Presses, presses_csv};
use crate::files;
use crate::pad::Pad;
use crate::platform::signals::Signals;
use crate::source::{Noise, RobotSource, Source};
use crate::touch::Detector;
use crate::types::{Method, PointMm};

/// Where presses come from.
#[derive(Clone, Copy, Debug)]
pub(super) struct PressSource<'a> {
    pub choice: &'a SourceChoice,
    pub board: BoardLine,
    /// Noise of the simulated pad.
    pub noise: NoiseLevel,
}

impl PressSource<'_> {
    /// Opens it; on the simulated pad without a script, a robot presses the places.
    pub(super) fn open(&self, pad: &Pad, places: &[PointMm]) -> anyhow::Result<Box<dyn Source>> {
        let NoiseLevel { snr_db, seed } = self.noise;
        let mut opened: Box<dyn Source> = match self.choice {
            SourceChoice::Level if places.is_empty() => {
                bail!(
                    "the simulated pad is not pressed: give a script, such as simulated:presses.txt"
                )
            }
            SourceChoice::Level => {
                let noise = Noise::new(snr_db, seed);
                Box::new(RobotSource::new(pad, places.to_vec(), noise, seed)?)
            }
            SourceChoice::Gamepad => bail!("a gamepad has no places to press"),
            source => open_pad_source(source, self.board, self.noise, pad)?,
        };
        opened.require_frames();
        Ok(opened)
    }

    fn presser(&self) -> Presser {
        match self.choice {
            SourceChoice::Serial(_) => Presser::Person,
            _ => Presser::Script,
        }
    }
}

/// Presses at shown places.
pub(super) struct GuidedPresses {
    pub presses: Presses,
    /// Readings of the untouched pad, frame by frame.
    pub untouched: Vec<Vec<f32>>,
    /// Whether every place was pressed.
    pub is_complete: bool,
    /// Still listening: what follows takes seconds.
    pub signals: Signals,
}

/// A signal, or the presses.
pub(super) enum Outcome {
    Signal(i32),
    Pressed(GuidedPresses),
}

/// Records a press at each of `count` places of a pad, located as `play` does it. `file` gets the presses, also after a signal or an
/// error: they are minutes of work.
///
/// # Errors
/// A source that fails; too few presses; a file that cannot be written.
pub(super) fn record_guided(
    pad: &Pad,
    source: PressSource<'_>,
    count: usize,
    method: Option<Method>,
    file: Option<&Path>,
) -> anyhow::Result<Outcome> {
    let method = method.or(pad.method).unwrap_or_default();
    let sensing = solve_pad(pad, method)?.build_initial()?;
    let detector = Detector::for_pad(Arc::new(sensing), &pad.protocol);
    let places = calibration_places(pad, count);
    let mut opened = source.open(pad, &places)?;
    let signals = Signals::listen()?;
    let mut recorded = GuidedReadings::default();
    let ending = record(
        pad,
        detector,
        opened.as_mut(),
        (source.presser(), &places),
        &mut recorded,
        &|| signals.received(),
    );
    let GuidedReadings { presses, untouched } = recorded;
    if let Some(path) = file.filter(|_| !presses.is_empty()) {
        files::write(path, presses_csv(&presses).as_bytes())?;
        say(&format!("{} presses: {}", presses.len(), path.display()));
    }
    if let Some(signal) = ending? {
        return Ok(Outcome::Signal(signal));
    }
    if presses.len() < FEWEST_PRESSES {
        bail!(
            "{} presses were recorded, but at least {FEWEST_PRESSES} are needed",
            presses.len()
        );
    }
    Ok(Outcome::Pressed(GuidedPresses {
        is_complete: presses.len() == places.len(),
        presses: Presses::new("the recording", presses)?,
        untouched: untouched.into(),
        signals,
    }))
}

/// Checks, before anybody presses a pad, that the presses and other files can be written.
///
/// # Errors
/// A file of presses that exists; a folder that does not.
pub(super) fn check_files(presses: Option<&Path>, others: &[&Path]) -> anyhow::Result<()> {
    if let Some(file) = presses.filter(|file| file.exists()) {
        bail!(
            "{} exists: it would be overwritten\n  help: name another file, or learn from it without recording again",
            file.display()
        );
    }
    for path in others.iter().copied().chain(presses) {
        let folder = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            bail!(
                "{} cannot be written: there is no folder {}",
                path.display(),
                folder.display()
            );
        }
    }
    if presses.is_none() {
        say("the presses are not saved: add --presses FILE to save them");
    }
    Ok(())
}
