//! Electrodes of a pad as written: places on the outline, each on conductor.

use std::ops::Range;

use toml::Spanned;

use super::{ElectrodesSpec, positive};
use crate::pad::{Conductor, Electrode, Outline};
use crate::types::Diagnostic;

/// Number of electrodes; fewer than four give no measurement.
const ELECTRODES: std::ops::RangeInclusive<i64> = 4..=64;
/// Narrower electrodes cannot be meshed, mm.
const LEAST_ELECTRODE_MM: f64 = 0.2;
/// Least share of an electrode that lies on conductor.
const LEAST_CONTACT: f64 = 0.5;
/// The first electrode is written at most so many times round the pad: further, it is a mistake in the unit.
const MOST_TURNS: f64 = 10.0;

/// A distance along the outline, and the span of the text that gives it.
type Place = (f64, Range<usize>);

pub(super) fn electrodes(
    spec: &ElectrodesSpec,
    outline: &Outline,
    conductor: &Conductor,
) -> Result<Vec<Electrode>, Diagnostic> {
    let count = *spec.count.get_ref();
    if !ELECTRODES.contains(&count) {
        let (least, most) = (ELECTRODES.start(), ELECTRODES.end());
        let message = format!("a pad has {least} to {most} electrodes, not {count}");
        return Err(Diagnostic::new(spec.count.span(), message, "here"));
    }
    let width_mm = positive(&spec.width_mm, "the electrode width")?;
    if width_mm < LEAST_ELECTRODE_MM {
        let message = format!("electrodes are at least {LEAST_ELECTRODE_MM} mm wide");
        return Err(Diagnostic::new(spec.width_mm.span(), message, "too narrow"));
    }
    let centres = match &spec.at_mm {
        Some(list) => listed_centres(spec, list, outline, count as usize)?,
        None => even_centres(spec, outline, count as usize)?,
    };
    let electrodes: Vec<Electrode> = centres
        .iter()
        .map(|(centre, _)| Electrode::centred_at(*centre, width_mm))
        .collect();
    check_gaps(spec, outline, &electrodes)?;
    for (index, (electrode, (_, span))) in electrodes.iter().zip(&centres).enumerate() {
        check_corners(outline, electrode, index + 1, span)?;
        check_contact(outline, conductor, electrode, index + 1, span)?;
    }
    Ok(electrodes)
}

/// Electrodes go once round the pad, counter-clockwise, and do not overlap.
fn check_gaps(
    spec: &ElectrodesSpec,
    outline: &Outline,
    electrodes: &[Electrode],
) -> Result<(), Diagnostic> {
    let perimeter = outline.perimeter_mm();
    let step = |i: usize| {
        let next = (i + 1) % electrodes.len();
        (electrodes[next].start_mm - electrodes[i].start_mm).rem_euclid(perimeter)
    };
    let round: f64 = (0..electrodes.len()).map(step).sum();
    if round > 1.5 * perimeter {
        let span = spec.at_mm.as_ref().map_or(spec.count.span(), Spanned::span);
        let message = "electrodes are listed counter-clockwise, once round the pad";
        return Err(Diagnostic::new(span, message, "another order"));
    }
    for (i, electrode) in electrodes.iter().enumerate() {
        let gap = step(i) - electrode.width_mm;
        if gap <= 0.0 {
            let next = (i + 1) % electrodes.len() + 1;
            let message = format!("electrodes {} and {next} overlap by {:.2} mm", i + 1, -gap);
            return Err(Diagnostic::new(
                spec.width_mm.span(),
                message,
                "too wide for their places",
            )
            .help(
                "electrodes are numbered counter-clockwise; make them narrower or move them apart",
            ));
        }
    }
    Ok(())
}

/// An electrode lies on one side of a rectangle.
fn check_corners(
    outline: &Outline,
    electrode: &Electrode,
    number: usize,
    span: &Range<usize>,
) -> Result<(), Diagnostic> {
    let corner = outline.corners_mm().into_iter().find(|corner| {
        let into = (corner - electrode.start_mm).rem_euclid(outline.perimeter_mm());
        into > 1e-9 && into < electrode.width_mm - 1e-9
    });
    let Some(corner) = corner else {
        return Ok(());
    };
    let [x, y] = outline.point_at(corner);
    let message = format!("electrode {number} would bend round the corner at ({x}, {y}) mm");
    Err(Diagnostic::new(span.clone(), message, "off the outline"))
}

/// Enough of an electrode touches conductor.
fn check_contact(
    outline: &Outline,
    conductor: &Conductor,
    electrode: &Electrode,
    number: usize,
    span: &Range<usize>,
) -> Result<(), Diagnostic> {
    let share = electrode.contact_share(outline, conductor);
    if share >= LEAST_CONTACT {
        return Ok(());
    }
    let [x, y] = electrode.centre_mm(outline);
    let message = format!(
        "electrode {number} at ({x:.1}, {y:.1}) mm lies between channels: {:.0} % of it touches conductor",
        100.0 * share
    );
    Err(Diagnostic::new(span.clone(), message, "between channels").help(
        "move it over the end of a channel, or set `margin_mm = 0` so that channels run along the edge",
    ))
}

/// The centres that `at_mm` lists.
fn listed_centres(
    spec: &ElectrodesSpec,
    list: &Spanned<Vec<Spanned<[f64; 2]>>>,
    outline: &Outline,
    count: usize,
) -> Result<Vec<Place>, Diagnostic> {
    if let Some(first) = spec.first_mm.as_ref().or(spec.first_deg.as_ref()) {
        let message = "`at_mm` lists every place: there is no first one to set";
        return Err(Diagnostic::new(first.span(), message, "remove this"));
    }
    if list.get_ref().len() != count {
        let message = format!("{} places for {count} electrodes", list.get_ref().len());
        return Err(Diagnostic::new(
            list.span(),
            message,
            "one place per electrode",
        ));
    }
    list.get_ref()
        .iter()
        .map(|place| {
            let [x, y] = *place.get_ref();
            let along = outline.distance_along([x, y]).ok_or_else(|| {
                let message = format!("the electrode at ({x}, {y}) mm is off the outline");
                Diagnostic::new(place.span(), message, "not on the edge")
            })?;
            Ok((along, place.span()))
        })
        .collect()
}

/// Evenly spaced centres.
fn even_centres(
    spec: &ElectrodesSpec,
    outline: &Outline,
    count: usize,
) -> Result<Vec<Place>, Diagnostic> {
    let step = outline.perimeter_mm() / count as f64;
    let first = match (&spec.first_mm, &spec.first_deg, outline) {
        (Some(first), None, _) => *first.get_ref(),
        (None, Some(first), Outline::Circle { radius_mm }) => {
            first.get_ref().to_radians() * radius_mm
        }
        (_, Some(first), _) => {
            return Err(Diagnostic::new(
                first.span(),
                "`first_deg` places electrodes on a circle, without `first_mm`",
                "remove this",
            ));
        }
        (None, None, Outline::Circle { .. }) => 0.0,
        (None, None, Outline::Rectangle { .. }) => step / 2.0,
    };
    let span = spec.count.span();
    let perimeter_mm = outline.perimeter_mm();
    // NaN is not within them either.
    let is_within = first.abs() <= MOST_TURNS * perimeter_mm;
    if !is_within {
        let message = format!(
            "the first electrode lies more than {MOST_TURNS} times round the pad, whose edge is {perimeter_mm:.1} mm long"
        );
        let given = spec.first_mm.as_ref().or(spec.first_deg.as_ref());
        let span = given.map_or(span, Spanned::span);
        return Err(Diagnostic::new(span, message, "off the outline"));
    }
    Ok((0..count)
        .map(|i| (first + i as f64 * step, span.clone()))
        .collect())
}

#[cfg(test)]
mod tests {
    use crate::pad::{Pad, shipped_pad};

    #[test]
    fn the_first_electrode_may_be_written_some_turns_on() {
        let text = shipped_pad("round-tank").expect("shipped").toml;
        assert!(text.contains("first_deg = 0.0"));
        let turned = |degrees: &str| {
            let text = text.replace("first_deg = 0.0", &format!("first_deg = {degrees}"));
            Pad::from_toml("round", &text)
        };
        let places = |degrees: &str| -> Vec<[f64; 2]> {
            let pad = turned(degrees).expect("sound");
            let electrodes = pad.electrodes.iter();
            electrodes.map(|one| one.centre_mm(&pad.outline)).collect()
        };
        let wanted = places("22.5");
        for degrees in ["382.5", "-337.5", "3262.5"] {
            for (at, place) in places(degrees).iter().zip(&wanted) {
                let off = libm::hypot(at[0] - place[0], at[1] - place[1]);
                assert!(off < 1e-9, "{degrees}: {at:?} instead of {place:?}");
            }
        }
        for degrees in ["3601.0", "-1e9", "nan", "inf"] {
            let error = turned(degrees).expect_err("far off");
            let message = &error.diagnostics[0].message;
            assert!(message.contains("10 times round"), "{degrees}: {message}");
        }
    }
}
