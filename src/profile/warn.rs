//! Warnings about a profile that can be played: bindings that can never fire, regions that are hidden or out of reach,
//! times that are hard to keep.

use super::diagnostics::Diagnostics;
use super::entries::{Data, Entries, Place, Text};
use super::{Area, Binding, Gesture, Mode, PlacedRegion, Profile, Region, Target};
use crate::types::PointMm;

/// Regions, which are shares of the pad, are tested on a pad of this size.
const TEST_PAD_MM: [f64; 2] = [100.0, 100.0];
/// Places tested along each side of a region.
const PLACES_PER_SIDE: usize = 101;
/// A tap shorter than this is hard to make on a soft pad.
const SHORT_TERM_MS: f64 = 100.0;
/// The pad can separate two fingers that are this far apart.
const SEPARATION_MM: f64 = 30.0;
/// Rounding of places.
const TOLERANCE_MM: f64 = 1e-6;

/// Adds all warnings about a profile; `places` are those of its bindings.
pub(super) fn check(profile: &Profile, text: &Text, places: &[Place], warnings: &mut Diagnostics) {
    let placed: Vec<PlacedRegion> = profile
        .regions
        .iter()
        .map(|region| region.placed(TEST_PAD_MM, &profile.settings.area))
        .collect();
    for index in 0..profile.regions.len() {
        check_region(profile, &placed, index, text, warnings);
    }
    for (binding, place) in profile.bindings.iter().zip(places) {
        check_layer(profile, binding, place, warnings);
        check_fires(profile, binding, place, warnings);
        check_chord(binding, &placed, place, warnings);
    }
    check_tapping_terms(text, warnings);
}

fn check_region(
    profile: &Profile,
    placed: &[PlacedRegion],
    index: usize,
    text: &Text,
    warnings: &mut Diagnostics,
) {
    let region = &profile.regions[index];
    let name = &region.name;
    let place = place_of(region, text);
    let bindings = &profile.bindings;
    let is_bound = bindings.iter().any(|one| one.regions.contains(&index));
    if is_hidden(profile, placed, index) {
        warnings.help(
            &place,
            format!("the region `{name}` is hidden: other regions cover all of it"),
            "never touched",
            "move it, raise its `order`, or set `exclusive = false` in the regions that cover it",
        );
    }
    if !region.rest && !is_bound {
        let message = format!("nothing is bound to the region `{name}`");
        warnings.push(&place, message, "does nothing");
    }
    if let Some(reachable) = profile.settings.reachable
        && is_bound
        && !is_within(&placed[index], &reachable)
    {
        warnings.help(
            &place,
            format!("the region `{name}` is out of reach"),
            "not in the reachable area",
            "set area_x, area_y, area_w and area_h to fit the whole profile into the reachable area",
        );
    }
}

/// Where the name of a region (or of the grid that it is a cell of) was written, else the top of the text.
fn place_of(region: &Region, text: &Text) -> Place {
    let is_named = |entries: &&Entries| match entries.get("name").map(|value| &value.data) {
        Some(Data::Text(name)) => {
            let rest = region.name.strip_prefix(name.as_str());
            let is_cell = entries.has("columns") && rest.is_some_and(|rest| rest.starts_with('-'));
            *name == region.name || is_cell
        }
        _ => false,
    };
    let entries = text.regions.iter().find(is_named);
    entries
        .map_or(&text.top.place, |entries| entries.place_of("name"))
        .clone()
}

/// Whether exclusive regions above a region cover all of it.
fn is_hidden(profile: &Profile, placed: &[PlacedRegion], index: usize) -> bool {
    let holds = |i: usize, point: PointMm| placed[i].contains(point, profile.regions[i].reach);
    let above: Vec<usize> = (0..index)
        .filter(|i| profile.regions[*i].exclusive)
        .collect();
    if above.is_empty() || profile.regions[index].footprint > 0.0 {
        return false;
    }
    let mut own = test_places(&placed[index])
        .filter(|point| holds(index, *point))
        .peekable();
    own.peek().is_some() && own.all(|point| above.iter().any(|i| holds(*i, point)))
}

/// Places all over the bounding box of a region.
fn test_places(placed: &PlacedRegion) -> impl Iterator<Item = PointMm> {
    let (low, high) = placed.bounds_mm();
    let at = move |i: usize, axis: usize| {
        low[axis] + (high[axis] - low[axis]) * (i as f64 + 0.5) / PLACES_PER_SIDE as f64
    };
    (0..PLACES_PER_SIDE * PLACES_PER_SIDE)
        .map(move |i| [at(i % PLACES_PER_SIDE, 0), at(i / PLACES_PER_SIDE, 1)])
}

fn is_within(placed: &PlacedRegion, area: &Area) -> bool {
    let (low, high) = placed.bounds_mm();
    let [width, height] = TEST_PAD_MM;
    low[0] >= area.x * width - TOLERANCE_MM
        && low[1] >= area.y * height - TOLERANCE_MM
        && high[0] <= (area.x + area.w) * width + TOLERANCE_MM
        && high[1] <= (area.y + area.h) * height + TOLERANCE_MM
}

fn check_layer(profile: &Profile, binding: &Binding, place: &Place, warnings: &mut Diagnostics) {
    let Some(layer) = binding.layer else {
        return;
    };
    let switches = |binding: &Binding| {
        let target = Target::Layer(layer);
        binding.targets.contains(&target) || binding.gesture.own_targets().contains(&target)
    };
    if !profile.bindings.iter().any(switches) {
        let name = &profile.layers[layer];
        warnings.help(
            place,
            format!("this binding can never fire: nothing turns its layer `{name}` on"),
            "never fires",
            format!("bind something to `layer:{name}`"),
        );
    }
}

fn check_fires(profile: &Profile, binding: &Binding, place: &Place, warnings: &mut Diagnostics) {
    let mut regions = binding.regions.iter();
    if regions.any(|region| profile.regions[*region].rest) {
        let message = "this binding can never fire: its region ignores touches (`rest = true`)";
        warnings.push(place, message, "never fires");
    }
    let settings = &profile.settings;
    if let Some((why, help)) = binding.gesture.never_fires(settings) {
        let message = format!("this binding can never fire: {why}");
        match help {
            Some(help) => warnings.help(place, message, "never fires", help),
            None => warnings.push(place, message, "never fires"),
        }
    }
    if let Mode::Turbo { period_ns, .. } = binding.mode
        && period_ns < settings.min_hold_ns + settings.min_gap_ns
    {
        warnings.push(
            place,
            "the binding repeats faster than min_hold_ms and min_gap_ms allow: presses will be slower",
            "too fast",
        );
    }
}

fn check_chord(
    binding: &Binding,
    placed: &[PlacedRegion],
    place: &Place,
    warnings: &mut Diagnostics,
) {
    let (Gesture::Chord(_), [a, b, ..]) = (&binding.gesture, binding.regions.as_slice()) else {
        return;
    };
    let [a, b] = [a, b].map(|region| placed[*region].centre_mm());
    let apart_mm = libm::hypot(a[0] - b[0], a[1] - b[1]);
    if apart_mm < SEPARATION_MM {
        warnings.push(
            place,
            format!("the regions of this chord are {apart_mm:.0} mm apart: the pad can separate two fingers at about {SEPARATION_MM} mm"),
            "hard to play",
        );
    }
}

/// Warns of tapping terms that are shorter than most taps.
fn check_tapping_terms(text: &Text, warnings: &mut Diagnostics) {
    for entries in std::iter::once(&text.top).chain(&text.bindings) {
        if let Some(value) = entries.get("tapping_term_ms")
            && let Data::Number(ms) = value.data
            && ms > 0.0
            && ms < SHORT_TERM_MS
        {
            warnings.help(
                &value.place,
                format!("a tapping term of {ms} ms is short: most taps last 60 to 150 ms"),
                "taps will be missed",
                "200 ms is usual",
            );
        }
    }
}
