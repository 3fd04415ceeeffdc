//! A stick: the offset of a touch from a centre, as two axes.

use super::curve::response;
use super::recognizer::{Playing, Recognizer};
use crate::gesture::fingers::TouchSample;
use crate::profile::{DeadZone, Stick};
use crate::types::PointMm;

#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) struct StickRecognizer {
    centre_mm: PointMm,
    radius_mm: f64,
}

impl Recognizer for StickRecognizer {
    type Gesture = Stick;
    const ONE_TOUCH: bool = true;

    fn down(own: &Stick, touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self {
        let (centre_mm, radius_mm) = playing.moment.layout.centre_and_radius(touch.place);
        let mut recognizer = Self {
            centre_mm: if own.floating { touch.at_mm } else { centre_mm },
            radius_mm,
        };
        recognizer.moved(own, touch, playing);
        recognizer
    }

    fn moved(&mut self, own: &Stick, touch: &TouchSample, playing: &mut Playing<'_, '_>) {
        let offset_mm = [0, 1].map(|i| touch.at_mm[i] - self.centre_mm[i]);
        set_axes(own, axes(own, offset_mm, self.radius_mm), playing);
    }

    fn up(&mut self, own: &Stick, playing: &mut Playing<'_, '_>) {
        set_axes(own, [0.0; 2], playing);
    }
}

fn set_axes(own: &Stick, values: [f32; 2], playing: &mut Playing<'_, '_>) {
    for (axis, value) in [own.x, own.y].into_iter().zip(values) {
        if let Some(axis) = axis {
            playing.set_axis(axis, value);
        }
    }
}

/// The axes x and y, -1..1, of a touch at an offset from the centre of a stick with a radius.
fn axes(own: &Stick, offset_mm: PointMm, radius_mm: f64) -> [f32; 2] {
    let mut way = offset_mm.map(|mm| if radius_mm > 0.0 { mm / radius_mm } else { 0.0 });
    let length = libm::sqrt(way[0] * way[0] + way[1] * way[1]);
    match own.dead_zone {
        DeadZone::Round if length > 0.0 => {
            let answer = response(&own.curve, length.min(1.0));
            way = way.map(|share| share / length * answer);
        }
        DeadZone::Round => {}
        DeadZone::Square => {
            way = way.map(|share| response(&own.curve, share.abs().min(1.0)).copysign(share));
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

fn gained(value: f64, gain: f64) -> f32 {
    (value * gain).clamp(-1.0, 1.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{Curve, Gains};

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
