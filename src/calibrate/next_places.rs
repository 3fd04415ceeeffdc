//! Where to press next: as far from every press as possible.
//!
//! A map of readings over the pad knows least where no press is near, and a Gaussian process that is alike everywhere says so by
//! distance alone. Weighing places by how steep the maps are there was tried on measured skins and was no better on one, worse on the
//! other (`SPREAD=1 scripts/hydrogel-presses.sh` measures places that are spread like these).

use crate::types::{PointMm, distance_mm};

/// Candidates along the longer side of the box around the presses.
const CANDIDATES_ALONG: f64 = 32.0;

/// The next place to press.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NextPlace {
    /// The place, mm.
    pub place_mm: PointMm,
    /// Distance to the nearest press, or to a place named before, mm.
    pub gap_mm: f64,
}

/// The candidates to press next, the first worth most; none without a press.
#[must_use]
pub fn next_places(
    pressed_mm: &[PointMm],
    candidates_mm: &[PointMm],
    count: usize,
) -> Vec<NextPlace> {
    if pressed_mm.is_empty() {
        return Vec::new();
    }
    let mut candidates: Vec<NextPlace> = candidates_mm
        .iter()
        .map(|place_mm| {
            let gaps = pressed_mm.iter().map(|p| distance_mm(*p, *place_mm));
            NextPlace {
                place_mm: *place_mm,
                gap_mm: gaps.fold(f64::INFINITY, f64::min),
            }
        })
        .collect();
    let mut next = Vec::new();
    while next.len() < count {
        let widest = candidates
            .iter()
            .copied()
            .max_by(|a, b| a.gap_mm.total_cmp(&b.gap_mm));
        let Some(widest) = widest.filter(|widest| widest.gap_mm > 0.0) else {
            break;
        };
        for candidate in &mut candidates {
            let gap_mm = distance_mm(candidate.place_mm, widest.place_mm);
            candidate.gap_mm = candidate.gap_mm.min(gap_mm);
        }
        next.push(widest);
    }
    next
}

/// Candidates within the box around presses, for a pad of which nothing else is known; none if the box has no area.
#[must_use]
pub fn places_between(pressed_mm: &[PointMm]) -> Vec<PointMm> {
    let side = |axis: usize| {
        let values = || pressed_mm.iter().map(|place| place[axis]);
        let low = values().fold(f64::INFINITY, f64::min);
        (low, values().fold(f64::NEG_INFINITY, f64::max) - low)
    };
    let sides = [side(0), side(1)];
    let step_mm = sides[0].1.max(sides[1].1) / CANDIDATES_ALONG;
    if step_mm.is_nan() || step_mm <= 0.0 {
        return Vec::new();
    }
    let steps = sides.map(|(_, length)| libm::round(length / step_mm) as usize);
    (0..=steps[0])
        .flat_map(|column| (0..=steps[1]).map(move |row| [column, row]))
        .map(|at| [0, 1].map(|k| sides[k].0 + step_mm * at[k] as f64))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_filled_widest_first() {
        // A square of 3 x 3 presses without its middle and without one of a side.
        let places: Vec<PointMm> = [0.0, 32.0, 64.0]
            .into_iter()
            .flat_map(|x| [0.0, 32.0, 64.0].map(|y| [x, y]))
            .filter(|place| ![[32.0, 32.0], [64.0, 32.0]].contains(place))
            .collect();
        let next = next_places(&places, &places_between(&places), 3);
        assert_eq!(next.len(), 3);
        // The widest gap lies between both missing places.
        assert!((next[0].place_mm[1] - 32.0).abs() < 3.0, "{next:?}");
        assert!((32.0..=64.0).contains(&next[0].place_mm[0]), "{next:?}");
        assert!(next.windows(2).all(|pair| pair[0].gap_mm >= pair[1].gap_mm));
        assert!(distance_mm(next[0].place_mm, next[1].place_mm) >= next[1].gap_mm - 1e-9);
    }

    #[test]
    fn a_single_press_has_no_box() {
        assert_eq!(places_between(&[[5.0, 5.0]]), Vec::<PointMm>::new());
        assert_eq!(places_between(&[]), Vec::<PointMm>::new());
    }

    #[test]
    fn what_is_pressed_is_not_asked_again() {
        let places = [[5.0, 5.0], [9.0, 5.0]];
        assert_eq!(next_places(&[], &places, 2), []);
        assert_eq!(next_places(&places, &places, 2), []);
        let next = next_places(&places[..1], &places, 2);
        let expected = NextPlace {
            place_mm: places[1],
            gap_mm: 4.0,
        };
        assert_eq!(next, [expected]);
    }
}
