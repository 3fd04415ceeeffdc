//! `gelpad calibrate`: records presses at shown places, learns from them, says what to expect.

mod file;
mod recommend;
mod record;

use std::io::Write as _;
use std::path::Path;
use std::sync::Arc;

use anyhow::bail;
use indicatif::ProgressBar;
use serde::Serialize;

use super::args::{CalibrateArgs, SourceArg};
use super::exit::Ending;
use super::resolve;
use crate::calibrate::{
    Curve, Errors, FEWEST_PRESSES, Presses, Regression, correction, learning_curve,
};
use crate::pad::Pad;
use crate::source::serial::SerialSource;
use crate::source::{Noise, Robot, Script, SimulatedSource, Source, open_file};
use crate::touch::Detector;
use crate::types::PointMm;

use record::Presser;

pub(super) use file::correction as read_correction;
#[cfg(feature = "gui")]
pub(super) use file::save;
#[cfg(feature = "gui")]
pub(super) use record::places;

/// Twice the presses are worth the trouble if they take off at least this share of the error.
const WORTH: f64 = 0.1;

pub(super) fn calibrate(args: &CalibrateArgs) -> anyhow::Result<Ending> {
    if let (Some(name), Some(source)) = (&args.recommend, &args.source) {
        return recommend::run(args, name, source);
    }
    match (&args.source, &args.presses, &args.evaluate) {
        (Some(source), _, _) => record(args, source),
        (None, Some(presses), Some(test)) => evaluate(presses, test),
        (None, Some(presses), None) => {
            let presses = file::presses(presses)?;
            learn(args, &presses)
        }
        (None, None, _) => bail!("nothing to learn from: give --presses FILE or --source"),
    }
}

/// The line of `--evaluate`.
#[derive(Serialize)]
struct Evaluation {
    n_train: usize,
    n_test: usize,
    mean_mm: f64,
    median_mm: f64,
    p95_mm: f64,
}

fn evaluate(train: &Path, test: &Path) -> anyhow::Result<Ending> {
    let (presses, unseen) = (file::presses(train)?, file::presses(test)?);
    if presses.channels() != unseen.channels() {
        bail!(
            "{}: {} channels, but {} has {}: both must be of the same pad",
            test.display(),
            unseen.channels(),
            train.display(),
            presses.channels()
        );
    }
    let spinner = Spinner::new();
    let regression = Regression::fit(&presses, &mut |stage| spinner.say(stage))?;
    drop(spinner);
    let errors = regression.evaluate(&unseen);
    let line = serde_json::to_string(&Evaluation {
        n_train: presses.len(),
        n_test: unseen.len(),
        mean_mm: errors.mean_mm,
        median_mm: errors.median_mm,
        p95_mm: errors.p95_mm,
    })?;
    writeln!(std::io::stdout(), "{line}")?;
    say(&format!(
        "cross-validation predicted {}",
        told(regression.expected())
    ));
    Ok(Ending::Done)
}

fn record(args: &CalibrateArgs, source: &SourceArg) -> anyhow::Result<Ending> {
    let pad = resolve::pad(&args.pad)?;
    if let Some(file) = args.presses.as_ref().filter(|file| file.exists()) {
        bail!(
            "{} exists: it would be overwritten\n  help: name another file, or learn from it without --source",
            file.display()
        );
    }
    // Nobody presses thirty places for a file that cannot be written.
    for path in args.output.iter().chain(&args.presses) {
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
    if args.presses.is_none() {
        say("the presses themselves are not kept: add --presses FILE to keep them");
    }
    let method = args.method.or(pad.method).unwrap_or_default();
    // Learned is what `play` gets wrong, so its own detector locates the presses.
    let sensing = resolve::sensing(&pad, method)?.first()?;
    let detector = Detector::of_pad(Arc::new(sensing), &pad.protocol);
    let places = record::places(&pad, args.points);
    let mut source = open(args, &pad, source, &places)?;
    let presser = match args.source {
        Some(SourceArg::Serial(_)) => Presser::Listens,
        _ => Presser::GoesOn,
    };
    let list = record::record(&pad, detector, source.as_mut(), presser, &places)?;
    if list.len() < FEWEST_PRESSES {
        bail!(
            "{} presses were taken, but at least {FEWEST_PRESSES} are needed",
            list.len()
        );
    }
    let complete = list.len() == places.len();
    let presses = Presses::new("the recording", list)?;
    if let Some(path) = &args.presses {
        file::write(path, &presses.to_csv())?;
        say(&format!("presses: {}", path.display()));
    }
    let ending = learn(args, &presses)?;
    Ok(if complete { ending } else { Ending::LostData })
}

/// Opens a source; on the simulated pad without a script, a robot presses places.
fn open(
    args: &CalibrateArgs,
    pad: &Pad,
    source: &SourceArg,
    places: &[PointMm],
) -> anyhow::Result<Box<dyn Source>> {
    Ok(match source {
        SourceArg::Simulated(None) if places.is_empty() => {
            bail!("nobody presses the simulated pad: give a script, as in simulated:presses.txt")
        }
        SourceArg::Simulated(None) => {
            let noise = Noise::new(args.snr, args.seed);
            Box::new(Robot::new(pad, places.to_vec(), noise, args.seed)?)
        }
        SourceArg::Simulated(Some(script)) => {
            let script = Script::parse(&script.display().to_string(), &resolve::read(script)?)?;
            Box::new(SimulatedSource::new(
                pad,
                &script,
                Noise::new(args.snr, args.seed),
            )?)
        }
        SourceArg::Serial(port) => Box::new(SerialSource::open(
            port,
            args.board.baud,
            pad,
            args.board.format,
        )?),
        SourceArg::Replay(file) => open_file(file, pad)?,
        SourceArg::Gamepad => bail!("a gamepad has no places that could be learned"),
    })
}

/// Learns from presses, says what to expect, and saves what can be applied.
fn learn(args: &CalibrateArgs, presses: &Presses) -> anyhow::Result<Ending> {
    if presses.is_modelled() {
        let pad = resolve::pad(&args.pad)?;
        return learn_correction(args, &pad, presses);
    }
    if args.output.is_some() {
        bail!(crate::calibrate::CalibrateError::NotModelled);
    }
    let spinner = Spinner::new();
    let curve = learning_curve(presses, &mut |some| {
        let regression = Regression::fit(some, &mut |stage| {
            spinner.say(&format!("{} presses: {stage}", some.len()));
        })?;
        Ok(regression.expected().mean_mm)
    })?;
    drop(spinner);
    say(&foretold(&curve));
    say(
        "nothing is saved: these presses do not tell what the pad's model made of them (see `gelpad calibrate --help`)",
    );
    Ok(Ending::Done)
}

fn learn_correction(args: &CalibrateArgs, pad: &Pad, presses: &Presses) -> anyhow::Result<Ending> {
    if presses.channels() != pad.channels() {
        bail!(
            "the presses have {} channels, but the pad {} has {}: choose their pad with --pad",
            presses.channels(),
            pad.name,
            pad.channels()
        );
    }
    let size_mm = pad.outline.size_mm();
    let spinner = Spinner::new();
    spinner.say("learning");
    let fitted = correction(presses, size_mm)?;
    let curve = learning_curve(presses, &mut |some| {
        spinner.say(&format!("{} presses", some.len()));
        Ok(correction(some, size_mm)?.lone.mean_mm)
    })?;
    drop(spinner);
    let path = match &args.output {
        Some(path) => path.clone(),
        None => file::default_path(&args.pad, pad),
    };
    file::save(&path, pad, &fitted.correction, fitted.lone.mean_mm)?;
    say(&format!("the model alone: {}", told(fitted.model)));
    say(&format!("a lone touch, corrected: {}", told(fitted.lone)));
    say(&format!(
        "one of several, corrected: {}",
        told(fitted.several)
    ));
    say(&foretold(&curve));
    say(&format!(
        "saved: {}\nuse it: gelpad play --pad {} --calibration {}",
        path.display(),
        args.pad,
        path.display()
    ));
    Ok(Ending::Done)
}

fn told(errors: Errors) -> String {
    let Errors {
        mean_mm,
        median_mm,
        p95_mm,
    } = errors;
    format!("mean {mean_mm:.2} mm, median {median_mm:.2}, 95 % within {p95_mm:.2}")
}

/// The curve in words.
fn foretold(curve: &Curve) -> String {
    let points: Vec<String> = curve
        .points
        .iter()
        .map(|(count, mean_mm)| format!("{count} presses {mean_mm:.2} mm"))
        .collect();
    let mut text = format!("expected error: {}", points.join(", "));
    if let (Some(twice_mm), Some((count, mean_mm))) = (curve.twice_mm, curve.points.last()) {
        let count = 2 * count;
        text.push_str(&if twice_mm < (1.0 - WORTH) * mean_mm {
            format!("; about {twice_mm:.2} mm with {count}: more presses help")
        } else {
            format!("; {count} would bring little ({twice_mm:.2} mm)")
        });
    }
    text
}

/// A line on the terminal that tells what is being done, and that something is; gone when dropped.
struct Spinner(ProgressBar);

impl Spinner {
    fn new() -> Self {
        Self(ProgressBar::new_spinner())
    }

    fn say(&self, stage: &str) {
        self.0.set_message(stage.to_owned());
        self.0.tick();
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

fn say(text: &str) {
    // A closed stderr is no reason to stop.
    let _ = writeln!(std::io::stderr(), "{text}");
}
