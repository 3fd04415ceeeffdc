//! Warnings about a profile that can be played: bindings that can never fire, regions that are hidden or out of reach,
//! times that are hard to keep.

use std::collections::BTreeMap;

use super::diagnostics::Diagnostics;
use super::entries::{Data, Entries, Place, Text};
use super::{Area, Binding, Gesture, Mode, PlacedRegion, Profile, Region, Target};
use crate::types::PointMm;

/// Regions, which are shares of the pad, are tested on a pad of this size.
const TEST_PAD_MM: [f64; 2] = [100.0, 100.0];
/// Places tested along each side of a region, unless there are many regions.
const PLACES_PER_SIDE: usize = 101;
/// Places tested in all regions together.
const ALL_PLACES: usize = 1_000_000;
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
    let mut is_bound = vec![false; profile.regions.len()];
    for region in profile.bindings.iter().flat_map(|one| &one.regions) {
        is_bound[*region] = true;
    }
    let named = named_regions(text);
    let covers = CoverMap::new(profile, &placed);
    for (index, is_bound) in is_bound.into_iter().enumerate() {
        let place = place_of(&profile.regions[index], text, &named);
        check_region(profile, &covers, index, is_bound, place, warnings);
    }
    let mut is_switched = vec![false; profile.layers.len()];
    for binding in &profile.bindings {
        for target in binding.targets.iter().chain(&binding.gesture.own_targets()) {
            if let Target::Layer(layer) = target {
                is_switched[*layer] = true;
            }
        }
    }
    for (binding, place) in profile.bindings.iter().zip(places) {
        check_layer(profile, binding, &is_switched, place, warnings);
        check_fires(profile, binding, place, warnings);
        check_chord(binding, &placed, place, warnings);
    }
    check_tapping_terms(text, warnings);
}

fn check_region(
    profile: &Profile,
    covers: &CoverMap<'_>,
    index: usize,
    is_bound: bool,
    place: &Place,
    warnings: &mut Diagnostics,
) {
    let region = &profile.regions[index];
    let name = &region.name;
    if covers.is_hidden(index) {
        warnings.help(
            place,
            format!("the region `{name}` is hidden: other regions cover all of it"),
            "never touched",
            "move it, raise its `order`, or set `exclusive = false` in the regions that cover it",
        );
    }
    if !region.rest && !is_bound {
        let message = format!("nothing is bound to the region `{name}`");
        warnings.push(place, message, "does nothing");
    }
    if let Some(reachable) = profile.settings.reachable
        && is_bound
        && !is_within(&covers.placed[index], &reachable)
    {
        warnings.help(
            place,
            format!("the region `{name}` is out of reach"),
            "not in the reachable area",
            "set area_x, area_y, area_w and area_h to fit the whole profile into the reachable area",
        );
    }
}

/// The table of each name, the first if there are several.
fn named_regions(text: &Text) -> BTreeMap<&str, &Entries> {
    let mut named = BTreeMap::new();
    for entries in &text.regions {
        if let Some(Data::Text(name)) = entries.get("name").map(|value| &value.data) {
            named.entry(name.as_str()).or_insert(entries);
        }
    }
    named
}

/// Where the name of a region (or of the grid that it is a cell of) was written, else the top of the text.
fn place_of<'a>(region: &Region, text: &'a Text, named: &BTreeMap<&str, &'a Entries>) -> &'a Place {
    let of_grid = || {
        let (grid, _) = region.name.rsplit_once('-')?;
        named.get(grid).filter(|entries| entries.has("columns"))
    };
    let entries = named.get(region.name.as_str()).or_else(of_grid);
    entries.map_or(&text.top.place, |entries| entries.place_of("name"))
}

/// Which regions may cover a place: those whose bounds reach its cell of a coarse grid over the pad.
struct CoverMap<'a> {
    profile: &'a Profile,
    placed: &'a [PlacedRegion],
    /// Exclusive regions of each cell, topmost first.
    cells: Vec<Vec<usize>>,
    places_per_side: usize,
}

/// Cells along each side of the pad.
const CELLS: usize = 32;

impl<'a> CoverMap<'a> {
    fn new(profile: &'a Profile, placed: &'a [PlacedRegion]) -> Self {
        let mut cells = vec![Vec::new(); CELLS * CELLS];
        for (index, region) in profile.regions.iter().enumerate() {
            if !region.exclusive {
                continue;
            }
            let (low, high) = placed[index].bounds_mm();
            // Rounding must not lose a cell.
            let margin_mm = placed[index].reach_mm(region.reach) + TOLERANCE_MM;
            let range = |axis: usize| {
                cell_of(low[axis] - margin_mm, axis)..=cell_of(high[axis] + margin_mm, axis)
            };
            for row in range(1) {
                for column in range(0) {
                    cells[row * CELLS + column].push(index);
                }
            }
        }
        let share = ALL_PLACES / profile.regions.len().max(1);
        Self {
            profile,
            placed,
            cells,
            places_per_side: share.isqrt().clamp(1, PLACES_PER_SIDE),
        }
    }

    /// Whether exclusive regions above a region cover all of it.
    fn is_hidden(&self, index: usize) -> bool {
        let regions = &self.profile.regions;
        let holds = |i: usize, point: PointMm| self.placed[i].contains(point, regions[i].reach);
        if regions[index].footprint > 0.0 {
            return false;
        }
        let is_covered = |point: PointMm| {
            let cell = cell_of(point[1], 1) * CELLS + cell_of(point[0], 0);
            let above = self.cells[cell].iter().take_while(|i| **i < index);
            above.copied().any(|i| holds(i, point))
        };
        let mut own = test_places(&self.placed[index], self.places_per_side)
            .filter(|point| holds(index, *point))
            .peekable();
        own.peek().is_some() && own.all(is_covered)
    }
}

/// The column or row of cells of a coordinate; places outside the pad belong to its edge.
fn cell_of(mm: f64, axis: usize) -> usize {
    // Negative numbers become 0.
    ((mm / TEST_PAD_MM[axis] * CELLS as f64) as usize).min(CELLS - 1)
}

/// Places all over the bounding box of a region.
fn test_places(placed: &PlacedRegion, per_side: usize) -> impl Iterator<Item = PointMm> {
    let (low, high) = placed.bounds_mm();
    let at = move |i: usize, axis: usize| {
        low[axis] + (high[axis] - low[axis]) * (i as f64 + 0.5) / per_side as f64
    };
    (0..per_side * per_side).map(move |i| [at(i % per_side, 0), at(i / per_side, 1)])
}

fn is_within(placed: &PlacedRegion, area: &Area) -> bool {
    let (low, high) = placed.bounds_mm();
    let [width, height] = TEST_PAD_MM;
    low[0] >= area.x * width - TOLERANCE_MM
        && low[1] >= area.y * height - TOLERANCE_MM
        && high[0] <= (area.x + area.w) * width + TOLERANCE_MM
        && high[1] <= (area.y + area.h) * height + TOLERANCE_MM
}

fn check_layer(
    profile: &Profile,
    binding: &Binding,
    is_switched: &[bool],
    place: &Place,
    warnings: &mut Diagnostics,
) {
    let Some(layer) = binding.layer else {
        return;
    };
    if !is_switched[layer] {
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
