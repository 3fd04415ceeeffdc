//! Identifies a pad from its untouched frames, and presses if there are any: those of a source for `gelpad pad identify`, those of a game
//! while it is played, and those of the window's guided presses.

mod from_presses;
mod in_play;
mod kept;
mod untouched;

pub use from_presses::FoundFromPresses;
pub(super) use from_presses::begin as begin_identifying;
pub(super) use in_play::Identification;
pub(crate) use in_play::PadIdentifier;

use rayon::prelude::*;
use toml_edit::{Array, DocumentMut, Item, Table, Value, value};

use super::AppError;
use super::pads::{PadText, start_workers};
use crate::calibrate::{MEAN_FRAMES, Presses};
use crate::eit::identify::{
    IdentifiedPad, KnownPress, KnownPresses, RestReadings, identify_with_presses, rest_medians,
};
use crate::pad::Pad;
use crate::source::{SkipLog, Source, SourceReading};
use crate::stats::{quantile, rms};

/// Decimals of lengths (mm) and factors in texts.
const DECIMALS: f64 = 1e4;
/// Frames of which the median is taken at least.
const FEWEST_FRAMES: usize = 5;

/// A pad as found, with its text.
pub(crate) struct FoundPad {
    /// What was found.
    pub found: IdentifiedPad,
    /// The drawing's text with what was found.
    pub toml: String,
    /// Frames read.
    pub frames: usize,
    /// Presses that were given.
    pub presses: usize,
}

/// Finds the pad that has these readings when nothing touches it, frame by frame, with the help of presses if there are any.
///
/// # Errors
/// Too few frames; readings or presses that no such pad explains; presses without the readings of the untouched pad, or of another
/// number of channels.
pub(crate) fn identify_pad(
    drawing: &PadText,
    untouched: &[Vec<f32>],
    presses: Option<&Presses>,
) -> Result<FoundPad, AppError> {
    let presses = presses.map(|presses| known_presses(&drawing.pad, presses));
    let presses = presses.transpose()?.unwrap_or_default();
    start_workers()?;
    if untouched.len() < FEWEST_FRAMES {
        return Err(AppError::Unsuitable(format!(
            "the source sent {} frames of the untouched pad: at least {FEWEST_FRAMES} are needed",
            untouched.len()
        )));
    }
    let (volts, deviations) = rest_medians(untouched);
    let rest = RestReadings {
        volts: &volts,
        deviations: &deviations,
    };
    let known = KnownPresses {
        presses: &presses,
        noise: press_noise(&deviations, untouched.len()),
    };
    let found = identify_with_presses(&drawing.pad, rest, known, &beside_each_other)
        .map_err(|error| AppError::Unsuitable(error.to_string()))?;
    let toml = text_with(&drawing.toml, &found.pad)
        .ok_or_else(|| AppError::Unsuitable("the pad's text has no tables".to_owned()))?;
    Ok(FoundPad {
        found,
        toml,
        frames: untouched.len(),
        presses: presses.len(),
    })
}

/// Presses as relative changes.
fn known_presses(pad: &Pad, presses: &Presses) -> Result<Vec<KnownPress>, AppError> {
    if presses.channels() != pad.channels() {
        return Err(AppError::Unsuitable(format!(
            "the presses have {} readings each, {} has {}",
            presses.channels(),
            pad.name,
            pad.channels()
        )));
    }
    let all: Vec<usize> = (0..presses.len()).collect();
    let changes = presses.relative_changes(&all).ok_or_else(|| {
        AppError::Unsuitable(
            "the presses have no readings of the untouched pad\n  help: add them as a row without a place: `,,v0,v1,...`"
                .to_owned(),
        )
    })?;
    let known = presses.list().iter().zip(changes.row_iter());
    Ok(known
        .map(|(press, changes)| KnownPress {
            place_mm: press.place_mm,
            changes: changes.iter().copied().collect(),
        })
        .collect())
}

/// Relative deviation of a press's change, from the deviations of medians over `frames` frames: it is a mean of fewer.
fn press_noise(deviations: &[f64], frames: usize) -> f64 {
    let finite = deviations.iter().copied().filter(|one| one.is_finite());
    let of_frame = quantile(finite, 0.5).unwrap_or(0.0) * (frames as f64).sqrt();
    of_frame / (MEAN_FRAMES as f64).sqrt()
}

/// Runs jobs on the threads of the present pool.
fn beside_each_other(count: usize, job: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(job);
}

/// Reads frames until there are so many or the source ends.
///
/// # Errors
/// A source that fails.
pub(crate) fn read_frames(
    source: &mut dyn Source,
    wanted: usize,
) -> Result<Vec<Vec<f32>>, AppError> {
    let mut frames = Vec::with_capacity(wanted);
    let mut log = SkipLog::default();
    while frames.len() < wanted {
        match source.read()? {
            SourceReading::Frame(frame) => {
                log.frame();
                frames.push(frame.volts);
            }
            SourceReading::Skipped { reason, .. } => log
                .skip(reason)
                .map_err(|error| AppError::Unsuitable(error.to_string()))?,
            SourceReading::Disconnected { reason } => tracing::warn!("{reason}"),
            SourceReading::Part(_) | SourceReading::Control(_) | SourceReading::Idle => {}
            SourceReading::End => break,
        }
    }
    Ok(frames)
}

/// A pad's text with a table `found`; `None` if it is no TOML.
fn text_with(text: &str, pad: &Pad) -> Option<String> {
    let mut document: DocumentMut = text.parse().ok()?;
    let mut found = Table::new();
    let rounded = |number: f64| (number * DECIMALS).round() / DECIMALS;
    let cells = pad.deviations.cells.iter().map(|([x, y], factor)| {
        let mut cell = Value::from(Array::from_iter([*x, *y, *factor].map(rounded)));
        cell.decor_mut().set_prefix("\n  ");
        cell
    });
    let mut cells = Array::from_iter(cells);
    cells.set_trailing("\n");
    let electrodes = &pad.deviations.electrodes;
    let list = |length: fn(&crate::pad::ElectrodeDeviation) -> f64| {
        value(Array::from_iter(electrodes.iter().map(length).map(rounded)))
    };
    found.insert("shift_mm", list(|electrode| electrode.shift_mm));
    found.insert("stretch_mm", list(|electrode| electrode.stretch_mm));
    found.insert("conductance", value(cells));
    found.decor_mut().set_prefix(
        "\n# How this pad differs from the drawing above, found by `gelpad pad identify`: how far each electrode is from its place along the\n\
         # edge and how much longer it is (mm), and the conductance of the layer around each site (x mm, y mm, factor).\n",
    );
    document.insert("found", Item::Table(found));
    Some(document.to_string())
}

/// What was found, in words: a line each.
pub(crate) fn describe(found: &FoundPad) -> String {
    let pad = &found.found.pad;
    let factors = || pad.deviations.cells.iter().map(|(_, factor)| *factor);
    let at = |share: f64| quantile(factors(), share).unwrap_or(1.0);
    let electrodes = &pad.deviations.electrodes;
    let shifts = || electrodes.iter().map(|electrode| electrode.shift_mm);
    let most = electrodes
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.shift_mm.abs().total_cmp(&b.1.shift_mm.abs()));
    let mut lines = vec![
        format!("pad          {}, {} frames", pad.name, found.frames),
        format!(
            "readings     {:.2} % off as drawn, {:.2} % as found (root mean square)",
            100.0 * found.found.misfit[0],
            100.0 * found.found.misfit[1]
        ),
        format!(
            "conductance  {:.0} to {:.0} % of the layer's (5 and 95 % of {} cells), median {:.0} %",
            100.0 * at(0.05),
            100.0 * at(0.95),
            pad.deviations.cells.len(),
            100.0 * at(0.5)
        ),
    ];
    if let Some((index, electrode)) = most {
        lines.push(format!(
            "electrodes   {:.2} mm from their places (root mean square); most, number {}, by {:+.2} mm",
            rms(shifts()),
            index + 1,
            electrode.shift_mm
        ));
    }
    if found.presses > 0 {
        lines.push(format!("presses      {}", describe_presses(found)));
    }
    lines.extend(broken(pad));
    lines.join("\n")
}

/// How many presses were used, and which were not.
fn describe_presses(found: &FoundPad) -> String {
    let left_out = &found.found.unexplained;
    let used = found.presses - left_out.len();
    if left_out.is_empty() {
        return format!("{used}, all explained");
    }
    let rows: Vec<String> = left_out
        .iter()
        .map(|press| (press + 1).to_string())
        .collect();
    format!(
        "{used} used; not explained, and left out: number {} (at another place, or of two fingers?)",
        rows.join(", ")
    )
}

/// Cells that conduct much less than those around them: channels that may be torn.
fn broken(pad: &Pad) -> Vec<String> {
    /// A piece of channel below this factor may be torn.
    const TORN: f64 = 0.4;
    let torn = pad
        .deviations
        .cells
        .iter()
        .filter(|(_, factor)| *factor < TORN);
    torn.map(|([x, y], factor)| {
        format!(
            "weak         at ({x:.0}, {y:.0}) mm: {:.0} %, perhaps torn or dry",
            100.0 * factor
        )
    })
    .collect()
}
