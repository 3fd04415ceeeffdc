//! A pad as written: the TOML, and its checks.
//!
//! Two stages: serde reads the text into the structs below (spans kept), then [`read`] turns them into a
//! [`Pad`] or says, at the place, why that pad cannot be built or measured.

use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;

use super::{Channel, Conductor, Electrode, Lattice, Outline, Pad, Pair, Protocol, TouchSign};
use crate::types::{Fault, Faulty, Method};

/// The version of the format that this reads.
const SCHEMA: i64 = 1;
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
/// More readings than this are no frame of a pad.
const MOST_CHANNELS: usize = 5000;
/// At least this share of an electrode must lie on conductor.
const LEAST_CONTACT: f64 = 0.5;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PadSpec {
    schema: Spanned<i64>,
    name: String,
    #[serde(default)]
    about: String,
    #[serde(default)]
    touch_sign: SignSpec,
    method: Option<Method>,
    outline: Spanned<OutlineSpec>,
    layer: LayerSpec,
    lattice: Option<LatticeSpec>,
    electrodes: ElectrodesSpec,
    protocol: Spanned<ProtocolSpec>,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum SignSpec {
    #[default]
    Rise,
    Fall,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ShapeSpec {
    Rectangle,
    Circle,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OutlineSpec {
    shape: ShapeSpec,
    width_mm: Option<Spanned<f64>>,
    height_mm: Option<Spanned<f64>>,
    radius_mm: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerSpec {
    thickness_mm: Spanned<f64>,
    background_s_per_m: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LatticeSpec {
    width_mm: Spanned<f64>,
    x_lines: Spanned<i64>,
    y_lines: Spanned<i64>,
    margin_mm: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ElectrodesSpec {
    count: Spanned<i64>,
    width_mm: Spanned<f64>,
    first_mm: Option<Spanned<f64>>,
    first_deg: Option<Spanned<f64>>,
    at_mm: Option<Spanned<Vec<Spanned<[f64; 2]>>>>,
    contact_impedance_ohm_m2: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ProtocolSpec {
    stimulation: Option<Spanned<String>>,
    measurement: Option<Spanned<String>>,
    #[serde(default)]
    readings: ReadingsSpec,
    drives: Option<Vec<[usize; 2]>>,
    measures: Option<Vec<[usize; 2]>>,
    channels: Option<Vec<[usize; 4]>>,
}

#[derive(Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
enum ReadingsSpec {
    #[default]
    Full,
    Half,
}

/// Reads and checks a pad. See [`Pad::from_toml`].
pub(super) fn read(name: &str, text: &str) -> Result<Pad, Faulty> {
    let spec: PadSpec = toml::from_str(text).map_err(|e| Faulty::from_toml(name, text, &e))?;
    build(&spec).map_err(|fault| Faulty::new(name, text, vec![fault]))
}

fn build(spec: &PadSpec) -> Result<Pad, Fault> {
    if *spec.schema.get_ref() != SCHEMA {
        return Err(Fault::new(
            spec.schema.span(),
            format!("schema {} is not known", spec.schema.get_ref()),
            "here",
        )
        .help(format!("this gelpad reads schema = {SCHEMA}")));
    }
    let outline = outline(&spec.outline)?;
    let conductor = conductor(spec.lattice.as_ref(), &outline)?;
    let electrodes = electrodes(&spec.electrodes, &outline, &conductor)?;
    let protocol = protocol(&spec.protocol, electrodes.len())?;
    Ok(Pad {
        name: spec.name.clone(),
        about: spec.about.clone(),
        outline,
        conductor,
        thickness_mm: positive(&spec.layer.thickness_mm, "the layer's thickness")?,
        background_s_per_m: positive(&spec.layer.background_s_per_m, "the conductivity")?,
        electrodes,
        contact_impedance_ohm_m2: positive(
            &spec.electrodes.contact_impedance_ohm_m2,
            "the contact impedance",
        )?,
        protocol,
        touch_sign: match spec.touch_sign {
            SignSpec::Rise => TouchSign::Rise,
            SignSpec::Fall => TouchSign::Fall,
        },
        method: spec.method,
    })
}

fn positive(value: &Spanned<f64>, what: &str) -> Result<f64, Fault> {
    let number = *value.get_ref();
    if number.is_finite() && number > 0.0 {
        Ok(number)
    } else {
        Err(Fault::new(
            value.span(),
            format!("{what} must be a number above zero"),
            "not above zero",
        ))
    }
}

fn outline(spec: &Spanned<OutlineSpec>) -> Result<Outline, Fault> {
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

fn conductor(spec: Option<&LatticeSpec>, outline: &Outline) -> Result<Conductor, Fault> {
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

fn electrodes(
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

fn protocol(spec: &Spanned<ProtocolSpec>, electrodes: usize) -> Result<Protocol, Fault> {
    let written = spec.get_ref();
    let half = written.readings == ReadingsSpec::Half;
    let made = if let Some(list) = &written.channels {
        let others = written.stimulation.is_some()
            || written.measurement.is_some()
            || written.drives.is_some()
            || written.measures.is_some()
            || half;
        if others {
            return Err(Fault::new(
                spec.span(),
                "`channels` lists every reading and goes without other patterns",
                "in this table",
            ));
        }
        let channels = list
            .iter()
            .map(|[a, b, p, q]| Channel {
                drive: Pair(*a, *b),
                measure: Pair(*p, *q),
            })
            .collect();
        Protocol::listed(electrodes, channels)
    } else {
        let drives = pattern(
            spec,
            &written.stimulation,
            &written.drives,
            "stimulation",
            electrodes,
        )?;
        let measures = pattern(
            spec,
            &written.measurement,
            &written.measures,
            "measurement",
            electrodes,
        )?;
        Protocol::crossed(electrodes, &drives, &measures, half)
    };
    let protocol =
        made.map_err(|error| Fault::new(spec.span(), error.to_string(), "in this table"))?;
    if protocol.channels.len() > MOST_CHANNELS {
        return Err(Fault::new(
            spec.span(),
            format!(
                "{} readings: a frame has at most {MOST_CHANNELS}",
                protocol.channels.len()
            ),
            "in this table",
        ));
    }
    Ok(protocol)
}

/// The pairs of a named pattern, or of an explicit list.
fn pattern(
    table: &Spanned<ProtocolSpec>,
    named: &Option<Spanned<String>>,
    listed: &Option<Vec<[usize; 2]>>,
    key: &str,
    electrodes: usize,
) -> Result<Vec<Pair>, Fault> {
    match (named, listed) {
        (Some(name), None) => {
            let step = step_of(name.get_ref(), electrodes).ok_or_else(|| {
                Fault::new(
                    name.span(),
                    format!("`{}` is no {key} pattern", name.get_ref()),
                    "not known",
                )
                .help(format!(
                    "write adjacent, opposite, or skip-K with K electrodes between the two (skip-2), K at most {}",
                    electrodes - 2
                ))
            })?;
            Ok(Protocol::stepped(electrodes, step))
        }
        (None, Some(list)) => Ok(list.iter().map(|[a, b]| Pair(*a, *b)).collect()),
        _ => Err(Fault::new(
            table.span(),
            format!("the protocol needs either `{key}` or its list of pairs"),
            "in this table",
        )),
    }
}

fn step_of(name: &str, electrodes: usize) -> Option<usize> {
    match name {
        "adjacent" => Some(1),
        "opposite" => Some(electrodes / 2),
        _ => {
            let skip: usize = name.strip_prefix("skip-")?.parse().ok()?;
            skip.checked_add(1).filter(|step| *step < electrodes)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, shipped_pad};

    /// The default pad's text with one passage replaced.
    fn edited(from: &str, to: &str) -> Result<Pad, Faulty> {
        let text = shipped_pad(DEFAULT_PAD).expect("shipped").toml;
        assert!(text.contains(from), "the pad's text holds `{from}`");
        Pad::from_toml("pad.toml", &text.replacen(from, to, 1))
    }

    fn refusal(from: &str, to: &str) -> (String, String) {
        let faulty = edited(from, to).expect_err("refused");
        let fault = &faulty.faults[0];
        (
            fault.message.clone(),
            faulty.text[fault.span.clone()].to_owned(),
        )
    }

    #[test]
    fn the_papers_pad_has_four_electrodes_a_side() {
        let pad = edited("schema = 1", "schema = 1").expect("sound");
        let centres: Vec<_> = pad
            .electrodes
            .iter()
            .map(|electrode| electrode.centre_mm(&pad.outline))
            .collect();
        assert_eq!(centres[0], [12.5, 0.0]);
        assert_eq!(centres[4], [100.0, 12.5]);
        assert_eq!(centres[8], [87.5, 100.0]);
        assert_eq!(centres[15], [0.0, 12.5]);
        assert_eq!(pad.channels(), 208);
    }

    #[test]
    fn impossible_pads_are_refused_at_the_word() {
        let cases: &[(&str, &str, &str, &str)] = &[
            (
                "width_mm = 2.0\nx",
                "width_mm = 10.0\nx",
                "channels of 10 mm overlap: 11 lines on 100 mm are 9.00 mm apart",
                "10.0",
            ),
            (
                "margin_mm = 0.0",
                "margin_mm = 3.0",
                "electrode 1 at (37.5, 0.0) mm lies between channels: 0 % of it touches conductor",
                "16",
            ),
            (
                "width_mm = 3.0",
                "width_mm = 25.5",
                "electrodes 0 and 1 overlap by 0.50 mm",
                "25.5",
            ),
            (
                "count = 16",
                "count = 3",
                "a pad has 4 to 64 electrodes, not 3",
                "3",
            ),
            (
                "width_mm = 3.0",
                "width_mm = 3.0\nfirst_mm = 1.0",
                "electrode 0 would bend round the corner at (0, 0) mm: off the outline",
                "16",
            ),
            (
                "thickness_mm = 2.0",
                "thickness_mm = -2.0",
                "the layer's thickness must be a number above zero",
                "-2.0",
            ),
            (
                "stimulation = \"adjacent\"",
                "stimulation = \"adjacant\"",
                "`adjacant` is no stimulation pattern",
                "\"adjacant\"",
            ),
            (
                "count = 16",
                "count = 4\nat_mm = [[10, 0], [100, 10], [50, 50], [0, 10]]",
                "the electrode at (50, 50) mm is off the outline",
                "[50, 50]",
            ),
            (
                "height_mm",
                "heigth_mm",
                "unknown field `heigth_mm`, expected one of `shape`, `width_mm`, `height_mm`, `radius_mm`",
                "heigth_mm",
            ),
        ];
        for (from, to, message, place) in cases {
            assert_eq!(
                refusal(from, to),
                ((*message).to_owned(), (*place).to_owned()),
                "{to}"
            );
        }
    }

    #[test]
    fn pads_that_cannot_be_solved_are_refused_before_they_are_meshed() {
        let cases: &[(&str, &str, &str)] = &[
            (
                "height_mm = 100.0",
                "height_mm = 1e9",
                "a pad measures 5 to 2000 mm across",
            ),
            (
                "height_mm = 100.0",
                "height_mm = 9.0",
                "a pad is at most 10 times as long as wide",
            ),
            (
                "width_mm = 2.0",
                "width_mm = 0.01",
                "channels of 0.01 mm on 2200 mm of lines are too thin to be solved: at least 0.10 mm",
            ),
            (
                "width_mm = 3.0",
                "width_mm = 0.05",
                "electrodes are at least 0.2 mm wide",
            ),
            (
                "margin_mm = 0.0",
                "margin_mm = 60.0",
                "the lattice's margin is 0 to 48 mm on this pad",
            ),
            (
                "count = 16",
                "count = 4\nat_mm = [[10, 0], [60, 0], [11, 0], [100, 50]]",
                "electrodes are listed counter-clockwise, once round the pad",
            ),
            (
                "\"adjacent\"",
                "\"skip-18446744073709551615\"",
                "`skip-18446744073709551615` is no stimulation pattern",
            ),
        ];
        for (from, to, said) in cases {
            assert_eq!(&refusal(from, to).0, said, "{to}");
        }
    }

    #[test]
    fn patterns_by_name_and_by_list() {
        let half = edited("readings = \"full\"", "readings = \"half\"").expect("104");
        assert_eq!(half.channels(), 104);
        let skip =
            edited("stimulation = \"adjacent\"", "stimulation = \"skip-2\"").expect("skip-2");
        assert_eq!(skip.protocol.channels[0].drive, Pair(0, 3));
        let listed = edited(
            "stimulation = \"adjacent\"\nmeasurement = \"adjacent\"",
            "channels = [[0, 1, 4, 5], [1, 2, 6, 7]]",
        )
        .expect("listed");
        assert_eq!(listed.channels(), 2);
    }
}
