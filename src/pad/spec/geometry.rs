//! Outline, conductor and electrodes of a pad as written: what can be built, and meshed.

use std::ops::Range;

use toml::Spanned;

use super::{DirectionSpec, ElectrodesSpec, LatticeSpec, OutlineSpec, ShapeSpec, positive};
use crate::pad::{Conductor, Direction, Electrode, Lattice, Numbering, Outline};
use crate::types::Fault;

/// Fewer electrodes than this give no measurement.
const ELECTRODES: std::ops::RangeInclusive<i64> = 4..=64;
/// Sides and diameters of pads, mm.
const SIZES_MM: std::ops::RangeInclusive<f64> = 5.0..=2000.0;
/// A pad is at most this many times as long as wide: beyond, electrodes far off read nothing.
const MOST_SLENDER: f64 = 10.0;
/// Lines of a lattice, each way.
const LINES: std::ops::RangeInclusive<i64> = 2..=200;
/// A channel is at least this wide beside the total length of all: thinner ones would need a mesh of over 200,000 nodes
/// (nine for each square of a channel's width).
const LEAST_WIDTH_SHARE: f64 = 9.0 / 200_000.0;
/// Narrower electrodes than this cannot be meshed, mm.
const LEAST_ELECTRODE_MM: f64 = 0.2;
/// At least this share of an electrode must lie on conductor.
const LEAST_CONTACT: f64 = 0.5;

pub(super) fn outline(spec: &Spanned<OutlineSpec>) -> Result<Outline, Fault> {
    let OutlineSpec {
        shape,
        width_mm,
        height_mm,
        radius_mm,
    } = spec.get_ref();
    let need = |value: &Option<Spanned<f64>>, key: &str| match value {
        Some(value) => {
            let number = positive(value, key)?;
            let size = if key == "radius_mm" {
                2.0 * number
            } else {
                number
            };
            if !SIZES_MM.contains(&size) {
                return Err(Fault::new(
                    value.span(),
                    format!(
                        "a pad measures {} to {} mm across",
                        SIZES_MM.start(),
                        SIZES_MM.end()
                    ),
                    "out of range",
                ));
            }
            Ok(number)
        }
        None => Err(Fault::new(
            spec.span(),
            format!("the outline needs `{key}`"),
            "in this table",
        )),
    };
    let refuse = |value: &Option<Spanned<f64>>, key: &str, shape: &str| match value {
        Some(value) => Err(Fault::new(
            value.span(),
            format!("a {shape} has no `{key}`"),
            "take this out",
        )),
        None => Ok(()),
    };
    match shape {
        ShapeSpec::Rectangle => {
            refuse(radius_mm, "radius_mm", "rectangle")?;
            let (width, height) = (need(width_mm, "width_mm")?, need(height_mm, "height_mm")?);
            if width.max(height) > MOST_SLENDER * width.min(height) {
                return Err(Fault::new(
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
            Ok(Outline::Circle {
                radius_mm: need(radius_mm, "radius_mm")?,
            })
        }
    }
}

pub(super) fn conductor(spec: Option<&LatticeSpec>, outline: &Outline) -> Result<Conductor, Fault> {
    let Some(spec) = spec else {
        return Ok(Conductor::Solid);
    };
    let channel_mm = positive(&spec.width_mm, "the channel width")?;
    let margin_mm = spec
        .margin_mm
        .as_ref()
        .map_or(0.0, |margin| *margin.get_ref());
    let size = outline.size_mm();
    let room = size[0].min(size[1]) / 2.0 - channel_mm;
    if !(margin_mm >= 0.0 && margin_mm < room) {
        let span = spec.margin_mm.as_ref().map_or(0..0, Spanned::span);
        return Err(Fault::new(
            span,
            format!("the lattice's margin is 0 to {room} mm on this pad"),
            "out of range",
        ));
    }
    for (lines, length) in [(&spec.x_lines, size[0]), (&spec.y_lines, size[1])] {
        let count = *lines.get_ref();
        if !LINES.contains(&count) {
            return Err(Fault::new(
                lines.span(),
                format!(
                    "a lattice has {} to {} lines each way, not {count}",
                    LINES.start(),
                    LINES.end()
                ),
                "here",
            ));
        }
        let pitch_mm = (length - 2.0 * margin_mm - channel_mm) / (count - 1) as f64;
        if channel_mm >= pitch_mm {
            return Err(Fault::new(
                spec.width_mm.span(),
                format!(
                    "channels of {channel_mm} mm overlap: {count} lines on {length} mm are {:.2} mm apart",
                    pitch_mm.max(0.0)
                ),
                "wider than the pitch",
            )
            .help("make the channels narrower, or take fewer lines"));
        }
    }
    let lines = [
        *spec.x_lines.get_ref() as usize,
        *spec.y_lines.get_ref() as usize,
    ];
    let total_mm = lines[0] as f64 * size[1] + lines[1] as f64 * size[0];
    if channel_mm < LEAST_WIDTH_SHARE * total_mm {
        return Err(Fault::new(
            spec.width_mm.span(),
            format!(
                "channels of {channel_mm} mm on {total_mm:.0} mm of lines are too thin to be solved: at least {:.2} mm",
                LEAST_WIDTH_SHARE * total_mm
            ),
            "too thin",
        ));
    }
    Ok(Conductor::Lattice(Lattice::even(
        size, channel_mm, lines, margin_mm,
    )))
}

pub(super) fn electrodes(
    spec: &ElectrodesSpec,
    outline: &Outline,
    conductor: &Conductor,
) -> Result<Vec<Electrode>, Fault> {
    let count = *spec.count.get_ref();
    if !ELECTRODES.contains(&count) {
        return Err(Fault::new(
            spec.count.span(),
            format!(
                "a pad has {} to {} electrodes, not {count}",
                ELECTRODES.start(),
                ELECTRODES.end()
            ),
            "here",
        ));
    }
    let width_mm = positive(&spec.width_mm, "the electrode width")?;
    if width_mm < LEAST_ELECTRODE_MM {
        return Err(Fault::new(
            spec.width_mm.span(),
            format!("electrodes are at least {LEAST_ELECTRODE_MM} mm wide"),
            "too narrow",
        ));
    }
    let centres = centres(spec, outline, count as usize)?;
    let electrodes: Vec<Electrode> = centres
        .iter()
        .map(|(centre, _)| Electrode::around(*centre, width_mm))
        .collect();
    let perimeter = outline.perimeter_mm();
    let step = |i: usize| {
        let next = (i + 1) % electrodes.len();
        (electrodes[next].start_mm - electrodes[i].start_mm).rem_euclid(perimeter)
    };
    let round: f64 = (0..electrodes.len()).map(step).sum();
    if round > 1.5 * perimeter {
        let span = spec.at_mm.as_ref().map_or(spec.count.span(), Spanned::span);
        return Err(Fault::new(
            span,
            "electrodes are listed counter-clockwise, once round the pad",
            "another order",
        ));
    }
    for (i, electrode) in electrodes.iter().enumerate() {
        let span = &centres[i].1;
        let next = (i + 1) % electrodes.len();
        let gap = (electrodes[next].start_mm - electrode.start_mm).rem_euclid(perimeter) - width_mm;
        if gap <= 0.0 {
            return Err(Fault::new(
                spec.width_mm.span(),
                format!("electrodes {i} and {next} overlap by {:.2} mm", -gap),
                "too wide for their places",
            )
            .help(
                "electrodes are numbered counter-clockwise; make them narrower or set them apart",
            ));
        }
        let corner = outline.corners_mm().into_iter().find(|corner| {
            let into = (corner - electrode.start_mm).rem_euclid(perimeter);
            into > 1e-9 && into < width_mm - 1e-9
        });
        if let Some(corner) = corner {
            let [x, y] = outline.point_at(corner);
            return Err(Fault::new(
                span.clone(),
                format!(
                    "electrode {i} would bend round the corner at ({x}, {y}) mm: off the outline"
                ),
                "off the outline",
            ));
        }
        let share = electrode.contact_share(outline, conductor);
        if share < LEAST_CONTACT {
            let [x, y] = electrode.centre_mm(outline);
            return Err(Fault::new(
                span.clone(),
                format!(
                    "electrode {i} at ({x:.1}, {y:.1}) mm lies between channels: {:.0} % of it touches conductor",
                    100.0 * share
                ),
                "between channels",
            )
            .help("move it over a channel's end, or set `margin_mm = 0` so that channels run along the edge"));
        }
    }
    Ok(electrodes)
}

/// How the board numbers so many places.
pub(super) fn numbering(spec: &ElectrodesSpec, places: usize) -> Result<Numbering, Fault> {
    let first = match &spec.first_electrode {
        None => 0,
        Some(first) => usize::try_from(*first.get_ref())
            .ok()
            .filter(|place| *place < places)
            .ok_or_else(|| {
                Fault::new(
                    first.span(),
                    format!(
                        "`first_electrode` is a place, 0 to {}, not {}",
                        places - 1,
                        first.get_ref()
                    ),
                    "no such place",
                )
            })?,
    };
    Ok(Numbering {
        first,
        direction: match spec.direction {
            DirectionSpec::CounterClockwise => Direction::CounterClockwise,
            DirectionSpec::Clockwise => Direction::Clockwise,
        },
    })
}

/// Centres along the edge, each with the words of the text that placed it.
fn centres(
    spec: &ElectrodesSpec,
    outline: &Outline,
    count: usize,
) -> Result<Vec<(f64, Range<usize>)>, Fault> {
    if let Some(list) = &spec.at_mm {
        if let Some(first) = spec.first_mm.as_ref().or(spec.first_deg.as_ref()) {
            return Err(Fault::new(
                first.span(),
                "`at_mm` gives every place and goes without a first one",
                "take this out",
            ));
        }
        if list.get_ref().len() != count {
            return Err(Fault::new(
                list.span(),
                format!("{} places for {count} electrodes", list.get_ref().len()),
                "one place an electrode",
            ));
        }
        return list
            .get_ref()
            .iter()
            .map(|place| {
                let [x, y] = *place.get_ref();
                outline
                    .along([x, y])
                    .map(|along| (along, place.span()))
                    .ok_or_else(|| {
                        Fault::new(
                            place.span(),
                            format!("the electrode at ({x}, {y}) mm is off the outline"),
                            "not on the edge",
                        )
                    })
            })
            .collect();
    }
    let step = outline.perimeter_mm() / count as f64;
    let first = match (&spec.first_mm, &spec.first_deg, outline) {
        (Some(first), None, _) => *first.get_ref(),
        (None, Some(first), Outline::Circle { radius_mm }) => {
            first.get_ref().to_radians() * radius_mm
        }
        (_, Some(first), _) => {
            return Err(Fault::new(
                first.span(),
                "`first_deg` places electrodes on a circle, and goes without `first_mm`",
                "take this out",
            ));
        }
        (None, None, Outline::Circle { .. }) => 0.0,
        (None, None, Outline::Rectangle { .. }) => step / 2.0,
    };
    if !first.is_finite() {
        return Err(Fault::new(
            spec.count.span(),
            "the first electrode's place is not a number",
            "here",
        ));
    }
    Ok((0..count)
        .map(|i| (first + i as f64 * step, spec.count.span()))
        .collect())
}
