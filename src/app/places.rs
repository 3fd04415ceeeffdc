//! Places for guided presses.

use crate::pad::Pad;
use crate::types::PointMm;

/// Least distance from the edge, as a fraction of the pad's shorter side.
const EDGE_FRACTION: f64 = 0.08;
/// Steps of the R2 sequence (Roberts 2018): powers of the inverse of the plastic number.
const R2_STEP: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];

/// Places spread evenly over a pad, whole mm; neighbours in the list are far apart on the pad.
pub(crate) fn calibration_places(pad: &Pad, count: usize) -> Vec<PointMm> {
    let size = pad.outline.size_mm();
    let edge = EDGE_FRACTION * size[0].min(size[1]);
    let is_inside = |[x, y]: PointMm| {
        [[edge, 0.0], [-edge, 0.0], [0.0, edge], [0.0, -edge]]
            .into_iter()
            .all(|[dx, dy]| pad.outline.contains([x + dx, y + dy]))
    };
    let place = |index: i32| {
        [0, 1].map(|axis| (0.5 + f64::from(index) * R2_STEP[axis]).fract() * size[axis])
    };
    (0..)
        .map(place)
        .filter(|place| is_inside(*place))
        .map(|place| place.map(f64::round))
        .take(count)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::SHIPPED_PADS;

    #[test]
    fn places_lie_on_every_pad_and_apart() {
        for shipped in SHIPPED_PADS {
            let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
            let places = calibration_places(&pad, 50);
            assert_eq!(places.len(), 50);
            for (i, a) in places.iter().enumerate() {
                assert!(pad.outline.contains(*a), "{}: {a:?}", pad.name);
                let size = pad.outline.size_mm();
                for b in &places[..i] {
                    let gap = (a[0] - b[0]).hypot(a[1] - b[1]);
                    assert!(gap > 0.05 * size[0].min(size[1]), "{a:?} {b:?}");
                }
            }
        }
    }
}
