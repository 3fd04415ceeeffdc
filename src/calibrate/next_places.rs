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

/// Candidates between presses (within their convex hull), for a pad of which nothing else is known.
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
        .filter(|place_mm| is_between(*place_mm, pressed_mm))
        .collect()
}

/// Whether presses surround a place: seen from it, no half of the horizon is empty.
fn is_between(place_mm: PointMm, pressed_mm: &[PointMm]) -> bool {
    let mut directions: Vec<f64> = pressed_mm
        .iter()
        .map(|p| libm::atan2(p[1] - place_mm[1], p[0] - place_mm[0]))
        .collect();
    directions.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (directions.first(), directions.last()) else {
        return false;
    };
    let round = first + std::f64::consts::TAU - last;
    let widest = directions.windows(2).map(|pair| pair[1] - pair[0]);
    widest.fold(round, f64::max) <= std::f64::consts::PI + 1e-9
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
    fn places_off_a_round_pad_are_not_asked_for() {
        let round: Vec<PointMm> = (0..24)
            .map(|k| f64::from(k) * std::f64::consts::TAU / 24.0)
            .map(|angle| {
                [
                    50.0 + 40.0 * libm::cos(angle),
                    50.0 + 40.0 * libm::sin(angle),
                ]
            })
            .collect();
        let candidates = places_between(&round);
        let off = |place: &PointMm| distance_mm(*place, [50.0, 50.0]);
        assert!(candidates.iter().all(|place| off(place) < 40.1));
        let next = next_places(&round, &candidates, 1);
        assert!(off(&next[0].place_mm) < 5.0, "{next:?}");
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
