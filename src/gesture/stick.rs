//! A stick: how far a touch lies from the middle, as two axes.

use crate::profile::{Curve, DeadZone, Stick};
use crate::types::PointMm;

/// The axes x and y, -1 to 1, for a touch at a place seen from the middle of a stick of a radius.
pub(super) fn axes(own: &Stick, offset_mm: PointMm, radius_mm: f64) -> [f32; 2] {
    let mut way = offset_mm.map(|mm| if radius_mm > 0.0 { mm / radius_mm } else { 0.0 });
    let length = libm::sqrt(way[0] * way[0] + way[1] * way[1]);
    match own.dead_zone {
        DeadZone::Round if length > 0.0 => {
            let answer = answer(&own.curve, length.min(1.0));
            way = way.map(|share| share / length * answer);
        }
        DeadZone::Round => {}
        DeadZone::Square => {
            way = way.map(|share| answer(&own.curve, share.abs().min(1.0)).copysign(share));
        }
    }
    let gain_x = if way[0] < 0.0 {
        own.gains.left
    } else {
        own.gains.right
    };
    let gain_y = if way[1] < 0.0 {
        own.gains.down
    } else {
        own.gains.up
    };
    [gained(way[0], gain_x), gained(way[1], gain_y)]
}

/// The answer of an axis to a share 0..1 of its way.
pub(super) fn answer(curve: &Curve, share: f64) -> f64 {
    if share < curve.dead_zone || share == 0.0 {
        return 0.0;
    }
    libm::pow(
        (share - curve.dead_zone) / (1.0 - curve.dead_zone),
        curve.exponent,
    )
}

fn gained(value: f64, gain: f64) -> f32 {
    (value * gain).clamp(-1.0, 1.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::Gains;

    fn stick(dead_zone: DeadZone) -> Stick {
        Stick {
            floating: false,
            dead_zone,
            curve: Curve {
                dead_zone: 0.2,
                exponent: 2.0,
            },
            gains: Gains {
                right: 1.0,
                up: 1.0,
                left: 2.0,
                down: 1.0,
            },
            x: None,
            y: None,
        }
    }

    #[test]
    fn a_round_dead_zone_keeps_the_direction() {
        let round = stick(DeadZone::Round);
        assert_eq!(axes(&round, [1.0, 1.0], 10.0), [0.0, 0.0]);
        let [x, y] = axes(&round, [6.0, 6.0], 10.0);
        assert!(x > 0.0 && x == y);
        assert_eq!(
            axes(&round, [30.0, 0.0], 10.0),
            [1.0, 0.0],
            "never beyond its end"
        );
    }

    #[test]
    fn a_square_dead_zone_frees_each_axis() {
        let square = stick(DeadZone::Square);
        assert_eq!(axes(&square, [10.0, 1.9], 10.0), [1.0, 0.0]);
        assert_eq!(
            axes(&square, [6.0, 0.0], 10.0),
            [0.25, 0.0],
            "half of the way, squared"
        );
        assert_eq!(
            axes(&square, [-6.0, 0.0], 10.0),
            [-0.5, 0.0],
            "twice the gain to the left"
        );
    }
}
