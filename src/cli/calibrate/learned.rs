//! `gelpad calibrate --presses FILE -o PAD.toml`: a pad that plays by what presses taught, without a model.

use std::path::Path;

use anyhow::bail;

use super::super::args::CalibrateArgs;
use super::{error_text, say_next_places};
use crate::app::calibration::is_pad_file;
use crate::app::learned_pad::{check_presses, pad_without_drawing, with_maps};
use crate::app::pads::{PadText, load_pad};
use crate::app::places::pressable_places;
use crate::app::texts::as_pad_argument;
use crate::calibrate::{LearnedErrors, Presses, learn_maps, learned_errors};
use crate::cli::exit::Ending;
use crate::cli::message::say;
use crate::cli::progress::Spinner;
use crate::files;

/// At least this share of the presses that were left out must be found.
const LEAST_FOUND_SHARE: f64 = 0.5;

/// Learns a pad and saves its text.
pub(super) fn learn_pad(
    args: &CalibrateArgs,
    presses: &Presses,
    output: &Path,
) -> anyhow::Result<Ending> {
    let drawing = drawing(args, presses, output)?;
    check_presses(presses, &drawing.pad, &drawing.pad.name)?;
    let spinner = Spinner::new();
    spinner.show("learning from four fifths of the presses");
    let errors = learned_errors(presses, &drawing.pad)?;
    if (errors.found as f64) < LEAST_FOUND_SHARE * errors.presses as f64 {
        bail!(
            "the presses disagree: {} of {} presses that were left out are found. Check that each place belongs to its row and that all presses come from one pad",
            errors.found,
            errors.presses
        );
    }
    spinner.show("learning from all presses");
    let maps = learn_maps(presses, drawing.pad.outline.size_mm())?;
    let learned = with_maps(&drawing, &maps)?;
    drop(spinner);
    files::write(output, learned.toml.as_bytes())?;
    let LearnedErrors {
        presses: tried,
        found,
        places,
    } = errors;
    say(&format!(
        "{found} of {tried} presses that were left out are found: {}",
        error_text(places)
    ));
    say_next_places(presses, &pressable_places(&drawing.pad));
    say(&format!(
        "saved: {}\nuse it: gelpad play --pad {}",
        output.display(),
        as_pad_argument(output)
    ));
    Ok(Ending::Done)
}

/// Refuses to overwrite the drawing, the presses, or a file that is there: before anybody presses a pad.
pub(super) fn check_output(args: &CalibrateArgs) -> anyhow::Result<()> {
    let Some(output) = args.output.as_ref().filter(|file| is_pad_file(file)) else {
        return Ok(());
    };
    if output.exists() {
        bail!(
            "{} exists: it would be overwritten\n  help: name another file, or remove it",
            output.display()
        );
    }
    Ok(())
}

/// The pad of the presses: as given, or a plain sheet of the given size.
fn drawing(args: &CalibrateArgs, presses: &Presses, output: &Path) -> anyhow::Result<PadText> {
    match args.size {
        None => Ok(load_pad(&args.pad)?),
        Some(size_mm) => {
            let name = output.file_stem().and_then(|stem| stem.to_str());
            Ok(pad_without_drawing(
                name.unwrap_or("learned"),
                size_mm,
                presses.channels(),
            )?)
        }
    }
}
