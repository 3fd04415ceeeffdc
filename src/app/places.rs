//! Places for guided presses.

use crate::pad::Pad;
use crate::types::PointMm;

/// Least distance from the edge, as a fraction of the pad's shorter side.
const EDGE_FRACTION: f64 = 0.08;
/// Steps of [`pressable_places`] along the longer side.
const STEPS_ALONG: f64 = 40.0;
/// Steps of the R2 sequence (Roberts 2018): powers of the inverse of the plastic number.
const R2_STEP: [f64; 2] = [0.754_877_666_246_693, 0.569_840_290_998_053];

/// Places spread evenly over a pad, whole mm; neighbours in the list are far apart on the pad.
pub(crate) fn calibration_places(pad: &Pad, count: usize) -> Vec<PointMm> {
    let size = pad.outline.size_mm();
    let place = |index: i32| {
        [0, 1].map(|axis| (0.5 + f64::from(index) * R2_STEP[axis]).fract() * size[axis])
    };
    (0..)
        .map(place)
        .filter(|place| leaves_an_edge(pad, *place))
        .map(|place| place.map(f64::round))
        .take(count)
        .collect()
}

/// Every place of a pad that calibrations may show, whole mm, a step of about a fortieth of the pad apart.
pub(crate) fn pressable_places(pad: &Pad) -> Vec<PointMm> {
    let [width, height] = pad.outline.size_mm();
    let step_mm = (width.max(height) / STEPS_ALONG).ceil().max(1.0);
    let along = |length: f64| (0..=(length / step_mm) as usize).map(move |k| step_mm * k as f64);
    along(width)
        .flat_map(|x| along(height).map(move |y| [x, y]))
        .filter(|place| leaves_an_edge(pad, *place))
        .collect()
}

/// Whether a place is on the pad, and not at its edge.
fn leaves_an_edge(pad: &Pad, [x, y]: PointMm) -> bool {
    let size = pad.outline.size_mm();
    let edge = EDGE_FRACTION * size[0].min(size[1]);
    [[edge, 0.0], [-edge, 0.0], [0.0, edge], [0.0, -edge]]
        .into_iter()
        .all(|[dx, dy]| pad.outline.contains([x + dx, y + dy]))
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
