//! What is odd about a profile that can be played: bindings that can never fire, regions that hide each other or lie
//! out of reach, times that are hard to keep.

use super::check::Faults;
use super::text::{Entries, Place, Text};
use super::{Area, Binding, Gesture, Mode, Placed, Profile, Region, Target};
use crate::types::{PointMm, nanos_from_ms};

/// Regions are looked at on a pad of this size; they are shares of it.
const LOOKED_AT_MM: [f64; 2] = [100.0, 100.0];
/// Places looked at along each side.
const LOOKS: usize = 101;
/// A tap shorter than this is hard to make on a soft pad.
const SHORT_TERM_MS: f64 = 100.0;
/// The pad tells two fingers apart from here on; nearer regions cannot be held together, mm.
const APART_MM: f64 = 30.0;

/// Looks at all of it.
pub(super) fn profile(
    profile: &Profile,
    text: &Text,
    binding_places: &[Place],
    warnings: &mut Faults,
) {
    let placed: Vec<Placed> = profile
        .regions
        .iter()
        .map(|region| region.placed(LOOKED_AT_MM, &profile.settings.area))
        .collect();
    let place_of = |region: &Region| place(region, text);
    for (index, region) in profile.regions.iter().enumerate() {
        if is_hidden(profile, &placed, index) {
            warnings.help(
                &place_of(region),
                format!(
                    "the region `{}` is hidden: others lie over all of it",
                    region.name
                ),
                "never touched",
                "move it, raise its `order`, or set `exclusive = false` in what lies over it",
            );
        }
        if !region.rest && !bound(profile, index) {
            warnings.push(
                &place_of(region),
                format!("nothing is bound to the region `{}`", region.name),
                "does nothing",
            );
        }
        if let Some(reachable) = profile.settings.reachable
            && bound(profile, index)
            && !within(&placed[index], &reachable)
        {
            warnings.help(
                &place_of(region),
                format!("the region `{}` lies out of reach", region.name),
                "not in the reachable area",
                "set area_x, area_y, area_w, area_h to lay the whole profile into what is reached",
            );
        }
    }
    bindings(profile, &placed, binding_places, warnings);
    short_terms(text, warnings);
}

/// Where a region was written: at its name, else in the text's first region.
fn place(region: &Region, text: &Text) -> Place {
    let named = |entries: &&Entries| {
        entries
            .values
            .get("name")
            .is_some_and(|value| match &value.data {
                super::text::Data::Text(name) => {
                    *name == region.name
                        || (entries.values.contains_key("columns")
                            && region
                                .name
                                .strip_prefix(name.as_str())
                                .is_some_and(|rest| rest.starts_with('-')))
                }
                _ => false,
            })
    };
    let entries = text.regions.iter().find(named);
    entries
        .and_then(|entries| entries.values.get("name"))
        .map_or_else(|| text.top.place.clone(), |value| value.place.clone())
}

/// Whether something is bound to a region.
fn bound(profile: &Profile, region: usize) -> bool {
    profile
        .bindings
        .iter()
        .any(|binding| binding.regions.contains(&region))
}

/// Whether every place of a region belongs to exclusive ones above it.
fn is_hidden(profile: &Profile, placed: &[Placed], index: usize) -> bool {
    let above: Vec<usize> = (0..index)
        .filter(|i| profile.regions[*i].exclusive)
        .collect();
    if above.is_empty() || profile.regions[index].footprint > 0.0 {
        return false;
    }
    let mut looked = false;
    for point in places(&placed[index]) {
        if placed[index].holds(point, profile.regions[index].reach) {
            looked = true;
            if !above
                .iter()
                .any(|i| placed[*i].holds(point, profile.regions[*i].reach))
            {
                return false;
            }
        }
    }
    looked
}

/// Places all over the box around a region.
fn places(placed: &Placed) -> impl Iterator<Item = PointMm> {
    let (low, high) = placed.bounds_mm();
    let at = move |i: usize, axis: usize| {
        low[axis] + (high[axis] - low[axis]) * (i as f64 + 0.5) / LOOKS as f64
    };
    (0..LOOKS * LOOKS).map(move |i| [at(i % LOOKS, 0), at(i / LOOKS, 1)])
}

fn within(placed: &Placed, area: &Area) -> bool {
    let (low, high) = placed.bounds_mm();
    let [width, height] = LOOKED_AT_MM;
    low[0] >= area.x * width - 1e-6
        && low[1] >= area.y * height - 1e-6
        && high[0] <= (area.x + area.w) * width + 1e-6
        && high[1] <= (area.y + area.h) * height + 1e-6
}

fn bindings(profile: &Profile, placed: &[Placed], places: &[Place], warnings: &mut Faults) {
    let turned_on = |layer: usize| {
        profile
            .bindings
            .iter()
            .any(|binding| drives(binding).any(|target| target == Target::Layer(layer)))
    };
    for (binding, place) in profile.bindings.iter().zip(places) {
        if let Some(layer) = binding.layer
            && !turned_on(layer)
        {
            let name = &profile.layers[layer];
            warnings.help(
                place,
                format!("this binding can never fire: nothing turns its layer `{name}` on"),
                "never",
                format!("bind something to `layer:{name}`"),
            );
        }
        if binding
            .regions
            .iter()
            .any(|region| profile.regions[*region].rest)
        {
            warnings.push(
                place,
                "this binding can never fire: its region is one to rest on",
                "never",
            );
        }
        never(profile, binding, place, warnings);
        if let (Gesture::Chord { .. }, [a, b, ..]) = (&binding.gesture, binding.regions.as_slice())
        {
            let [ca, cb] = [a, b].map(|region| placed[*region].centre_mm());
            let apart = libm::hypot(ca[0] - cb[0], ca[1] - cb[1]);
            if apart < APART_MM {
                warnings.push(place, format!("the regions of this chord lie {apart:.0} mm apart: the pad tells two fingers from one at about {APART_MM} mm"), "hard to play");
            }
        }
    }
}

fn drives(binding: &Binding) -> impl Iterator<Item = Target> + '_ {
    let more: &[Target] = match &binding.gesture {
        Gesture::TapHold(tap_hold) => &tap_hold.hold,
        _ => &[],
    };
    let pads: &[Option<Target>] = match &binding.gesture {
        Gesture::Dpad(dpad) => &dpad.targets,
        _ => &[],
    };
    binding
        .targets
        .iter()
        .chain(more)
        .copied()
        .chain(pads.iter().copied().flatten())
}

/// Gestures whose own numbers forbid them, and modes that cannot keep their times.
fn never(profile: &Profile, binding: &Binding, place: &Place, warnings: &mut Faults) {
    let settings = &profile.settings;
    match &binding.gesture {
        Gesture::Tap { within_ns, .. } | Gesture::DoubleTap { within_ns, .. }
            if *within_ns == 0 =>
        {
            warnings.push(
                place,
                "this binding can never fire: its tapping term is 0",
                "never",
            );
        }
        Gesture::Swipe(_) if settings.assist != super::Assist::Off => {
            warnings.push(
                place,
                "this binding can never fire: with touch assistance a touch has one place only",
                "never",
            );
        }
        Gesture::Contacts { count }
            if settings.panic_contacts.is_some_and(|panic| *count >= panic) =>
        {
            warnings.help(
                place,
                "this binding can never fire: so many contacts are the panic gesture",
                "never",
                "set `panic_contacts` higher, or to 0",
            );
        }
        Gesture::Hold { .. } | Gesture::TapHold(_) if settings.activate == super::Activate::Up => {
            warnings.push(
                place,
                "this binding can never fire as a hold: touches act when they lift",
                "never",
            );
        }
        Gesture::Chord { window_ns } if *window_ns == 0 => {
            warnings.push(
                place,
                "this binding can never fire: `chord_ms` is 0",
                "never",
            );
        }
        Gesture::Swipe(swipe) if swipe.within_ns == 0 => {
            warnings.push(
                place,
                "this binding can never fire: `swipe_ms` is 0",
                "never",
            );
        }
        _ => {}
    }
    if let Mode::Turbo { period_ns, .. } = binding.mode
        && period_ns < settings.min_hold_ns + settings.min_gap_ns
    {
        warnings.push(
            place,
            "this is faster than min_hold_ms and min_gap_ms allow: presses come slower than asked",
            "too fast",
        );
    }
}

/// Tapping terms that fingers do not keep.
fn short_terms(text: &Text, warnings: &mut Faults) {
    for entries in std::iter::once(&text.top).chain(&text.bindings) {
        if let Some(value) = entries.values.get("tapping_term_ms")
            && let super::text::Data::Number(ms) = value.data
            && ms > 0.0
            && nanos_from_ms(ms) < nanos_from_ms(SHORT_TERM_MS)
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
