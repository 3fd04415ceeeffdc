//! `gelpad calibrate`: records presses at shown places, learns a calibration, prints the expected error.

mod evaluate;
mod learned;
mod recommend;

use std::path::{Path, PathBuf};

use anyhow::bail;

use super::args::CalibrateArgs;
use super::exit::Ending;
use super::guided_presses::{Outcome, check_files, record_guided};
use super::message::say;
use super::progress::Spinner;
use crate::app::calibration::{default_path, is_pad_file, load_presses, save};
use crate::app::learned_pad::check_presses;
use crate::app::pads::load_pad;
use crate::app::places::pressable_places;
use crate::app::services::SourceChoice;
use crate::calibrate::{
    LearningCurve, PlaceErrors, Presses, Regression, fit_correction, learning_curve, next_places,
    places_between,
};
use crate::pad::Pad;
use crate::types::PointMm;

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
    let outputs: Vec<&Path> = args.output.iter().map(PathBuf::as_path).collect();
    check_files(args.presses.as_deref(), &outputs)?;
    let source = args.press_source(source);
    let file = args.presses.as_deref();
    // The calibration corrects the detector that `play` uses, so that detector locates the presses.
    let recorded = match record_guided(&pad, source, args.points, args.method, file)? {
        Outcome::Signal(signal) => return Ok(Ending::Signal(signal)),
        Outcome::Pressed(recorded) => recorded,
    };
    let has_drawing = pad.learned.is_none();
    let ending = learn(args, &recorded.presses, Some(pad))?;
    if let (Some(file), SourceChoice::Serial(port), true) = (file, source.choice, has_drawing) {
        say(&format!(
            "these presses tell how the pad itself differs from its drawing, too:\n  gelpad pad identify {} --source serial:{port} --presses {} -o FILE.toml",
            args.pad,
            file.display()
        ));
    }
    if let Some(signal) = recorded.signals.received() {
        return Ok(Ending::Signal(signal));
    }
    Ok(if recorded.is_complete {
        ending
    } else {
        Ending::LostData
    })
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
