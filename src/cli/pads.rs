//! `gelpad pad`: lists, checks and shows pads.

use std::io::Write as _;

use super::args::PadCommand;
use super::exit::Ending;
use super::identify;
use super::map::Map;
use super::message::{for_stdout, say};
use crate::app::folders::own_texts;
use crate::app::pads::{load_pad, reconstruction};
use crate::app::texts::pad_text;
use crate::eit::Linearised;
use crate::pad::{Conductor, Outline, Pad, SHIPPED_PADS, TouchSign};
use crate::types::{Method, printable};

/// A pad with fewer readings is reported: no order of the shipped pad keeps an error of 0.3 mm with fewer (docs/studies.md).
const FEWEST_READINGS: usize = 25;

pub(super) fn run(command: &PadCommand) -> anyhow::Result<Ending> {
    let mut stdout = std::io::stdout().lock();
    match command {
        PadCommand::List => list(&mut stdout)?,
        PadCommand::Check { pad: argument } => {
            let pad = load_pad(argument)?.pad;
            let matrix = reconstruction(&pad, Method::default())?;
            writeln!(
                stdout,
                "{}: sound: {} electrodes, {} voltages per frame, {} pixels",
                printable(argument),
                pad.electrodes.len(),
                pad.channels(),
                matrix.unknowns()
            )?;
            if let Some(maps) = &pad.learned {
                say(&format!(
                    "it responds as {} presses taught, not as drawn",
                    maps.presses
                ));
            }
            if pad.channels() < FEWEST_READINGS {
                say(&format!(
                    "warning: {} readings are too few to tell places: 8 electrodes give 40, 16 give 208",
                    pad.channels()
                ));
            }
        }
        PadCommand::Show { pad, toml: true } => {
            write!(stdout, "{}", for_stdout(&pad_text(pad)?.toml))?;
        }
        PadCommand::Show { pad, toml: false } => {
            let pad = load_pad(pad)?.pad;
            let linearised = Linearised::from_pad(&pad)?;
            writeln!(
                stdout,
                "{}",
                Map::new(pad.outline.size_mm(), 60).with_pad(&pad).framed()
            )?;
            writeln!(stdout, "{}", printable(&facts(&pad, &linearised)))?;
        }
        PadCommand::Identify(args) => {
            drop(stdout);
            return identify::run(args);
        }
    }
    Ok(Ending::Done)
}

/// A line for each pad: the shipped, then one's own.
fn list(stdout: &mut impl std::io::Write) -> anyhow::Result<()> {
    for shipped in SHIPPED_PADS {
        let pad = Pad::from_toml(shipped.name, shipped.toml)?;
        writeln!(stdout, "{:20} {}", pad.name, pad.about)?;
    }
    for path in own_texts("pads") {
        let name = std::path::Path::new(&path).file_stem().unwrap_or_default();
        let name = name.to_string_lossy();
        // A pad with mistakes is listed, too: `pad check` shows them.
        let about = load_pad(&name).map_or("has mistakes".to_owned(), |own| own.pad.about);
        let row = format!("{name:20} {about} (yours)");
        writeln!(stdout, "{}", printable(&row))?;
    }
    Ok(())
}

fn facts(pad: &Pad, linearised: &Linearised) -> String {
    let outline = match pad.outline {
        Outline::Rectangle {
            width_mm,
            height_mm,
        } => format!("rectangle, {width_mm} x {height_mm} mm"),
        Outline::Circle { radius_mm } => format!("circle, radius {radius_mm} mm"),
    };
    let conductor = match &pad.conductor {
        Conductor::Solid => "solid".to_owned(),
        Conductor::Lattice(lattice) => format!(
            "lattice, {} x {} channels of {} mm",
            lattice.x_lines_mm.len(),
            lattice.y_lines_mm.len(),
            lattice.width_mm
        ),
    };
    let sign = match pad.touch_sign {
        TouchSign::Rise => "conducts better, as far as is known: the first touches tell",
        TouchSign::Fall => "conducts worse, as far as is known: the first touches tell",
    };
    let response = match &pad.learned {
        None => "as drawn".to_owned(),
        Some(maps) => format!("as {} presses taught, not as drawn", maps.presses),
    };
    [
        format!("name         {}", pad.name),
        format!("             {}", pad.about),
        format!("outline      {outline}"),
        format!(
            "conductor    {conductor}; {} mm thick, {} S/m",
            pad.thickness_mm, pad.background_s_per_m
        ),
        format!(
            "electrodes   {} of {} mm",
            pad.electrodes.len(),
            pad.electrodes[0].width_mm
        ),
        format!("responds     {response}"),
        format!("frame        {} voltages", pad.channels()),
        format!(
            "image        {} pixels of {} mm",
            linearised.active.len(),
            linearised.grid.pixel_mm
        ),
        format!("a touch      {sign}"),
    ]
    .join("\n")
}
