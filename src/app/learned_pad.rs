//! The text of a pad that was learned from presses: that of its drawing, or of a plain sheet, with the learned maps.

use toml_edit::{Array, DocumentMut, Item, Table, Value, value};

use super::AppError;
use super::pads::PadText;
use crate::calibrate::Presses;
use crate::pad::{LearnedMaps, Pad};

/// Significant digits of the maps' numbers.
const DIGITS: usize = 5;
/// Electrodes that a pad without a drawing may have.
const ELECTRODES: std::ops::RangeInclusive<usize> = 8..=64;
/// Usual protocols, most usual first: stimulation, readings per electrode less than there are electrodes, only for even counts.
const PROTOCOLS: [(&str, usize, bool); 2] = [("adjacent", 3, false), ("opposite", 4, true)];

/// A rectangular pad of which only its size (mm) and its number of readings are known.
///
/// # Errors
/// A size that no pad has; a number of readings that no usual protocol gives.
pub(crate) fn pad_without_drawing(
    name: &str,
    [width_mm, height_mm]: [f64; 2],
    channels: usize,
) -> Result<PadText, AppError> {
    let usual = PROTOCOLS.iter().find_map(|(stimulation, fewer, is_even)| {
        let fits = |count: &usize| {
            count * (count - fewer) == channels && (!is_even || count.is_multiple_of(2))
        };
        Some((stimulation, ELECTRODES.clone().find(fits)?))
    });
    let Some((stimulation, count)) = usual else {
        return Err(AppError::Unsuitable(format!(
            "{channels} readings are those of no usual protocol\n  help: describe electrodes and protocol in a pad's text, and give it with --pad (see docs/pads.md)"
        )));
    };
    // Half of the edge is electrodes: where they lie does not matter, the maps say how the pad responds.
    let electrode_mm = (width_mm + height_mm) / count as f64;
    let toml = format!(
        "schema = 1\nname = {}\nabout = \"learned from presses, without a drawing\"\ntouch_sign = \"rise\"\n\n\
         [outline]\nshape = \"rectangle\"\nwidth_mm = {width_mm:?}\nheight_mm = {height_mm:?}\n\n\
         # Not used: the maps below say how the pad responds.\n\
         [layer]\nthickness_mm = 2.0\nbackground_s_per_m = 1.0\n\n\
         [electrodes]\ncount = {count}\nwidth_mm = {:?}\ncontact_impedance_ohm_m2 = 1e-4\n\n\
         # A guess by the number of readings: only lost electrodes are found by it.\n\
         [protocol]\nstimulation = \"{stimulation}\"\nmeasurement = \"adjacent\"\n",
        Value::from(name),
        electrode_mm * 0.25,
    );
    Ok(PadText {
        pad: Pad::from_toml(name, &toml)?,
        toml,
    })
}

/// A pad's text with learned maps.
///
/// # Errors
/// A text that is no table; maps that do not fit the pad.
pub(crate) fn with_maps(pad: &PadText, maps: &LearnedMaps) -> Result<PadText, AppError> {
    let unsuitable = |reason: String| AppError::Unsuitable(reason);
    let mut document: DocumentMut = pad
        .toml
        .parse()
        .map_err(|error: toml_edit::TomlError| unsuitable(error.to_string()))?;
    let mut learned = Table::new();
    learned.insert("presses", value(maps.presses as i64));
    learned.insert(
        "counts",
        value(Array::from_iter(maps.counts.map(|count| count as i64))),
    );
    learned.insert("directions", lists(&maps.directions));
    learned.insert("deviations", value(numbers(&maps.deviations)));
    learned.insert("shared", lists(&maps.shared));
    learned.insert("responses", lists(&maps.responses));
    learned.decor_mut().set_prefix(
        "\n# How the pad responds to a press at each place, learned by `gelpad calibrate`: it replaces the drawing above.\n",
    );
    document.remove("found");
    document.insert("learned", Item::Table(learned));
    let toml = document.to_string();
    Ok(PadText {
        pad: Pad::from_toml(&pad.pad.name, &toml)?,
        toml,
    })
}

/// A list of numbers a line.
fn lists(rows: &[Vec<f64>]) -> Item {
    let mut list = Array::from_iter(rows.iter().map(|row| {
        let mut row = Value::from(numbers(row));
        row.decor_mut().set_prefix("\n  ");
        row
    }));
    list.set_trailing("\n");
    value(list)
}

fn numbers(row: &[f64]) -> Array {
    Array::from_iter(row.iter().map(|number| rounded(*number)))
}

/// A number with the digits that matter.
fn rounded(number: f64) -> f64 {
    format!("{number:.*e}", DIGITS - 1)
        .parse()
        .unwrap_or(number)
}

/// Whether presses fit a pad: the same number of readings, and places on it.
///
/// # Errors
/// The first way in which they do not fit, with what to do.
pub(crate) fn check_presses(presses: &Presses, pad: &Pad, argument: &str) -> Result<(), AppError> {
    let (has, wants) = (presses.channels(), pad.channels());
    if has != wants {
        return Err(AppError::Unsuitable(format!(
            "the presses have {has} channels, but the pad {} has {wants}: choose their pad with --pad",
            pad.name
        )));
    }
    let [width, height] = pad.outline.size_mm();
    let places = presses.list().iter().map(|press| press.place_mm);
    let off = (1..)
        .zip(places)
        .find(|(_, [x, y])| !((0.0..=width).contains(x) && (0.0..=height).contains(y)));
    match off {
        None => Ok(()),
        Some((index, [x, y])) => Err(AppError::Unsuitable(format!(
            "press {index} lies at ({x}, {y}) mm, off the pad {argument} of {width} x {height} mm: correct its place, remove its row, or choose another pad with --pad"
        ))),
    }
}
