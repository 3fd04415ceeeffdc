//! `gelpad calibrate`: records presses at shown places, learns a calibration, prints the expected error.

mod evaluate;
mod learned;
mod recommend;
mod record;
mod source;

use std::sync::Arc;

use anyhow::bail;

use super::args::CalibrateArgs;
use super::exit::Ending;
use super::message::say;
use super::progress::{Spinner, solve_pad};
use crate::app::calibration::{default_path, is_pad_file, load_presses, save};
use crate::app::learned_pad::check_presses;
use crate::app::pads::load_pad;
use crate::app::places::{calibration_places, pressable_places};
use crate::app::services::SourceChoice;
use crate::calibrate::{
    FEWEST_PRESSES, LearningCurve, PlaceErrors, Presses, Regression, fit_correction,
    learning_curve, next_places, places_between, presses_csv,
};
use crate::files;
use crate::pad::Pad;
use crate::platform::signals::Signals;
use crate::touch::Detector;
use crate::types::PointMm;
use record::Presser;

/// Twice as many presses are recommended if they reduce the error by at least this fraction.
const WORTHWHILE_GAIN: f64 = 0.1;

/// Places that are named for more presses.
const NEXT_PLACES: usize = 3;

pub(super) fn calibrate(args: &CalibrateArgs) -> anyhow::Result<Ending> {
    if let (Some(name), Some(source)) = (&args.recommend, &args.source) {
        return recommend::run(args, name, source);
    }
    learned::check_output(args)?;
    match (&args.source, &args.presses, &args.evaluate) {
        (Some(source), _, _) => record(args, source),
        (None, Some(presses), Some(test)) => evaluate::evaluate(presses, test),
        (None, Some(presses), None) => {
            let presses = load_presses(presses)?;
            learn(args, &presses, None)
        }
        (None, None, _) => bail!("no presses: give --presses FILE or --source"),
    }
}

fn record(args: &CalibrateArgs, source: &SourceChoice) -> anyhow::Result<Ending> {
    let pad = load_pad(&args.pad)?.pad;
    check_files(args)?;
    let method = args.method.or(pad.method).unwrap_or_default();
    // The calibration corrects the detector that `play` uses, so that detector locates the presses.
    let sensing = solve_pad(&pad, method)?.build_initial()?;
    let detector = Detector::for_pad(Arc::new(sensing), &pad.protocol);
    let places = calibration_places(&pad, args.points);
    let mut source_of_presses = source::open(args, &pad, source, &places)?;
    let presser = match source {
        SourceChoice::Serial(_) => Presser::Person,
        _ => Presser::Script,
    };
    // Minutes of work: what was pressed is kept, also after Ctrl-C or an error.
    let signals = Signals::listen()?;
    let mut list = Vec::new();
    let recorded = record::record(
        &pad,
        detector,
        source_of_presses.as_mut(),
        presser,
        &places,
        &mut list,
        &|| signals.received(),
    );
    if let Some(path) = args.presses.as_ref().filter(|_| !list.is_empty()) {
        files::write(path, presses_csv(&list).as_bytes())?;
        say(&format!("{} presses: {}", list.len(), path.display()));
    }
    if let Some(signal) = recorded? {
        return Ok(Ending::Signal(signal));
    }
    if list.len() < FEWEST_PRESSES {
        bail!(
            "{} presses were recorded, but at least {FEWEST_PRESSES} are needed",
            list.len()
        );
    }
    let complete = list.len() == places.len();
    let presses = Presses::new("the recording", list)?;
    let ending = learn(args, &presses, Some(pad))?;
    if let Some(signal) = signals.received() {
        return Ok(Ending::Signal(signal));
    }
    Ok(if complete { ending } else { Ending::LostData })
}

/// Checks, before anybody presses a pad, that the files can be written.
fn check_files(args: &CalibrateArgs) -> anyhow::Result<()> {
    if let Some(file) = args.presses.as_ref().filter(|file| file.exists()) {
        bail!(
            "{} exists: it would be overwritten\n  help: name another file, or learn from it without --source",
            file.display()
        );
    }
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
        say("the presses are not saved: add --presses FILE to save them");
    }
    Ok(())
}

/// Prints the expected error of a calibration, and saves it if the presses contain the model's places.
fn learn(args: &CalibrateArgs, presses: &Presses, pad: Option<Pad>) -> anyhow::Result<Ending> {
    if let Some(output) = args.output.as_ref().filter(|file| is_pad_file(file)) {
        return learned::learn_pad(args, presses, output);
    }
    if presses.is_modelled() {
        let pad = match pad {
            Some(pad) => pad,
            None => load_pad(&args.pad)?.pad,
        };
        return learn_correction(args, &pad, presses);
    }
    if args.output.is_some() || args.size.is_some() {
        bail!(crate::calibrate::CalibrateError::NotModelled);
    }
    let spinner = Spinner::new();
    let curve = learning_curve(presses, &mut |some| {
        let regression = Regression::fit(some, &mut |stage| {
            spinner.show(&format!("{} presses: {stage}", some.len()));
        })?;
        Ok(regression.expected().mean_mm)
    })?;
    drop(spinner);
    say(&curve_text(&curve));
    say_next_places(presses, &places_between(&places_of(presses)));
    say(
        "nothing is saved: to learn a pad that plays from these presses, add --size WIDTHxHEIGHT -o FILE.toml",
    );
    Ok(Ending::Done)
}

fn learn_correction(args: &CalibrateArgs, pad: &Pad, presses: &Presses) -> anyhow::Result<Ending> {
    check_presses(presses, pad, &args.pad)?;
    let size_mm = pad.outline.size_mm();
    let spinner = Spinner::new();
    spinner.show("learning");
    let fitted = fit_correction(presses, size_mm)?.checked()?;
    let curve = learning_curve(presses, &mut |some| {
        spinner.show(&format!("{} presses", some.len()));
        Ok(fit_correction(some, size_mm)?.lone.mean_mm)
    })?;
    drop(spinner);
    let path = match &args.output {
        Some(path) => path.clone(),
        None => default_path(&args.pad, pad),
    };
    save(&path, pad, &fitted.correction, fitted.lone.mean_mm)?;
    say(&format!(
        "without calibration: {}",
        error_text(fitted.model)
    ));
    say(&format!(
        "a lone touch, corrected: {}",
        error_text(fitted.lone)
    ));
    say(&format!(
        "one of several, corrected: {}",
        error_text(fitted.several)
    ));
    say(&curve_text(&curve));
    say_next_places(presses, &pressable_places(pad));
    say(&format!(
        "saved: {}\nuse it: gelpad play --pad {} --calibration {}",
        path.display(),
        args.pad,
        path.display()
    ));
    Ok(Ending::Done)
}

/// Says where more presses would teach most.
fn say_next_places(presses: &Presses, candidates_mm: &[PointMm]) {
    let next = next_places(&places_of(presses), candidates_mm, NEXT_PLACES);
    let Some(widest) = next.first() else { return };
    let places: Vec<String> = next
        .iter()
        .map(|next| format!("({:.0}, {:.0})", next.place_mm[0], next.place_mm[1]))
        .collect();
    say(&format!(
        "more presses teach most at {} mm: nothing was pressed within {:.0} mm of the first",
        places.join(", "),
        widest.gap_mm
    ));
}

fn places_of(presses: &Presses) -> Vec<PointMm> {
    presses.list().iter().map(|press| press.place_mm).collect()
}

fn error_text(errors: PlaceErrors) -> String {
    let PlaceErrors {
        mean_mm,
        median_mm,
        p95_mm,
    } = errors;
    format!("mean {mean_mm:.2} mm, median {median_mm:.2}, 95 % within {p95_mm:.2}")
}

/// The learning curve as text.
fn curve_text(curve: &LearningCurve) -> String {
    let points: Vec<String> = curve
        .points
        .iter()
        .map(|(count, mean_mm)| format!("{count} presses {mean_mm:.2} mm"))
        .collect();
    let mut text = format!("expected error: {}", points.join(", "));
    if let (Some(twice_mm), Some((count, mean_mm))) = (curve.twice_mm, curve.points.last()) {
        let count = 2 * count;
        text.push_str(&if twice_mm < (1.0 - WORTHWHILE_GAIN) * mean_mm {
            format!("; about {twice_mm:.2} mm with {count}: more presses help")
        } else {
            format!("; {count} would help little ({twice_mm:.2} mm)")
        });
    }
    text
}
