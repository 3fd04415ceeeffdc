//! Outline, conductor and numbering of a pad as written: what can be built and meshed.

use toml::Spanned;

use super::{DirectionSpec, ElectrodesSpec, LatticeSpec, OutlineSpec, ShapeSpec, positive};
use crate::pad::{Conductor, Direction, Lattice, Numbering, Outline};
use crate::types::Diagnostic;

/// Sides and diameters of pads, mm.
const SIZES_MM: std::ops::RangeInclusive<f64> = 5.0..=2000.0;
/// Largest ratio of a pad's sides: beyond, distant electrodes read nothing.
const MOST_SLENDER: f64 = 10.0;
/// Lines of a lattice in each direction.
const LINES: std::ops::RangeInclusive<i64> = 2..=200;
/// Least width of a channel as a share of the total length of all channels: thinner ones would need a mesh of more than
/// 200,000 nodes (nine per square of the channel's width).
const LEAST_WIDTH_SHARE: f64 = 9.0 / 200_000.0;

pub(super) fn outline(spec: &Spanned<OutlineSpec>) -> Result<Outline, Diagnostic> {
    let OutlineSpec {
        shape,
        width_mm,
        height_mm,
        radius_mm,
    } = spec.get_ref();
    match shape {
        ShapeSpec::Rectangle => {
            refuse(radius_mm, "radius_mm", "rectangle")?;
            let width = length(spec, width_mm, "width_mm", 1.0)?;
            let height = length(spec, height_mm, "height_mm", 1.0)?;
            if width.max(height) > MOST_SLENDER * width.min(height) {
                return Err(Diagnostic::new(
                    spec.span(),
                    format!("a pad is at most {MOST_SLENDER} times as long as wide"),
                    "too slender",
                ));
            }
            Ok(Outline::Rectangle {
                width_mm: width,
                height_mm: height,
            })
        }
        ShapeSpec::Circle => {
            refuse(width_mm, "width_mm", "circle")?;
            refuse(height_mm, "height_mm", "circle")?;
            let radius_mm = length(spec, radius_mm, "radius_mm", 2.0)?;
            Ok(Outline::Circle { radius_mm })
        }
    }
}

/// A length of the outline; the pad measures `times` of it across.
fn length(
    outline: &Spanned<OutlineSpec>,
    value: &Option<Spanned<f64>>,
    key: &str,
    times: f64,
) -> Result<f64, Diagnostic> {
    let Some(value) = value else {
        let message = format!("the outline needs `{key}`");
        return Err(Diagnostic::new(outline.span(), message, "in this table"));
    };
    let number = positive(value, key)?;
    if SIZES_MM.contains(&(times * number)) {
        return Ok(number);
    }
    let (least, most) = (SIZES_MM.start(), SIZES_MM.end());
    let message = format!("a pad measures {least} to {most} mm across");
    Err(Diagnostic::new(value.span(), message, "out of range"))
}

/// Refuses a key that does not belong to a shape.
fn refuse(value: &Option<Spanned<f64>>, key: &str, shape: &str) -> Result<(), Diagnostic> {
    match value {
        Some(value) => {
            let message = format!("a {shape} has no `{key}`");
            Err(Diagnostic::new(value.span(), message, "remove this"))
        }
        None => Ok(()),
    }
}

pub(super) fn conductor(
    spec: Option<&LatticeSpec>,
    outline: &Outline,
) -> Result<Conductor, Diagnostic> {
    let Some(spec) = spec else {
        return Ok(Conductor::Solid);
    };
    let channel_mm = positive(&spec.width_mm, "the channel width")?;
    let size = outline.size_mm();
    let margin_mm = margin(spec, size, channel_mm)?;
    for (lines, length_mm) in [(&spec.x_lines, size[0]), (&spec.y_lines, size[1])] {
        check_pitch(spec, lines, length_mm - 2.0 * margin_mm, length_mm)?;
    }
    let lines = [&spec.x_lines, &spec.y_lines].map(|lines| *lines.get_ref() as usize);
    let total_mm = lines[0] as f64 * size[1] + lines[1] as f64 * size[0];
    let least_mm = LEAST_WIDTH_SHARE * total_mm;
    if channel_mm < least_mm {
        return Err(Diagnostic::new(
            spec.width_mm.span(),
            format!(
                "channels of {channel_mm} mm on {total_mm:.0} mm of lines are too thin to be solved: at least {least_mm:.2} mm"
            ),
            "too thin",
        ));
    }
    let lattice = Lattice::even(size, channel_mm, lines, margin_mm);
    Ok(Conductor::Lattice(lattice))
}

/// The distance of the outermost channels from the edges, mm.
fn margin(spec: &LatticeSpec, size: [f64; 2], channel_mm: f64) -> Result<f64, Diagnostic> {
    let Some(margin) = &spec.margin_mm else {
        return Ok(0.0);
    };
    let room_mm = size[0].min(size[1]) / 2.0 - channel_mm;
    let margin_mm = *margin.get_ref();
    if margin_mm >= 0.0 && margin_mm < room_mm {
        return Ok(margin_mm);
    }
    let message = format!("the lattice's margin is 0 to {room_mm} mm on this pad");
    Err(Diagnostic::new(margin.span(), message, "out of range"))
}

/// Checks the number and pitch of the lines in one direction; they fill `room_mm` of `length_mm`.
fn check_pitch(
    spec: &LatticeSpec,
    lines: &Spanned<i64>,
    room_mm: f64,
    length_mm: f64,
) -> Result<(), Diagnostic> {
    let (count, channel_mm) = (*lines.get_ref(), *spec.width_mm.get_ref());
    if !LINES.contains(&count) {
        let (least, most) = (LINES.start(), LINES.end());
        let message =
            format!("a lattice has {least} to {most} lines in each direction, not {count}");
        return Err(Diagnostic::new(lines.span(), message, "here"));
    }
    let pitch_mm = (room_mm - channel_mm) / (count - 1) as f64;
    if channel_mm < pitch_mm {
        return Ok(());
    }
    let message = format!(
        "channels of {channel_mm} mm overlap: {count} lines on {length_mm} mm are {:.2} mm apart",
        pitch_mm.max(0.0)
    );
    Err(
        Diagnostic::new(spec.width_mm.span(), message, "wider than the pitch")
            .help("make the channels narrower, or use fewer lines"),
    )
}

/// How the board numbers the electrodes.
pub(super) fn numbering(spec: &ElectrodesSpec, places: usize) -> Result<Numbering, Diagnostic> {
    let first = match &spec.first_electrode {
        None => 0,
        Some(first) => match usize::try_from(*first.get_ref()) {
            Ok(place) if place < places => place,
            _ => {
                let (last, given) = (places - 1, first.get_ref());
                let message = format!(
                    "`first_electrode` is a place counted from 0: 0 to {last}, not {given}"
                );
                return Err(Diagnostic::new(first.span(), message, "no such place"));
            }
        },
    };
    Ok(Numbering {
        first,
        direction: match spec.direction {
            DirectionSpec::CounterClockwise => Direction::CounterClockwise,
            DirectionSpec::Clockwise => Direction::Clockwise,
        },
    })
}
