//! A d-pad: directions from the centre of its region, by the angle; a touch slides across them.

use super::recognizer::{Playing, Recognizer};
use crate::gesture::fingers::TouchSample;
use crate::profile::Dpad;
use crate::types::PointMm;

#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) struct DpadRecognizer {
    /// Directions that are down: right, up, left, down as bits 0 to 3.
    down: u8,
    centre_mm: PointMm,
    radius_mm: f64,
}

impl Recognizer for DpadRecognizer {
    type Gesture = Dpad;
    const ONE_TOUCH: bool = true;

    fn down(own: &Dpad, touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self {
        let (centre_mm, radius_mm) = playing.moment.layout.centre_and_radius(touch.place);
        let mut recognizer = Self {
            down: 0,
            centre_mm,
            radius_mm,
        };
        recognizer.moved(own, touch, playing);
        recognizer
    }

    fn moved(&mut self, own: &Dpad, touch: &TouchSample, playing: &mut Playing<'_, '_>) {
        let offset_mm = [0, 1].map(|i| touch.at_mm[i] - self.centre_mm[i]);
        self.turn(own, directions(own, offset_mm, self.radius_mm), playing);
    }

    fn up(&mut self, own: &Dpad, playing: &mut Playing<'_, '_>) {
        self.turn(own, 0, playing);
    }
}

impl DpadRecognizer {
    /// Releases the directions that are over, then presses the new ones.
    fn turn(&mut self, own: &Dpad, now: u8, playing: &mut Playing<'_, '_>) {
        let before = std::mem::replace(&mut self.down, now);
        let targets = || own.targets.iter().enumerate();
        let is_in = |bits: u8, bit: usize| bits & (1 << bit) != 0;
        for (bit, target) in targets() {
            if let Some(target) = target
                && is_in(before & !now, bit)
            {
                playing.let_go(*target);
            }
        }
        for (bit, target) in targets() {
            if let Some(target) = target
                && is_in(now & !before, bit)
            {
                playing.hold(*target);
            }
        }
    }
}

/// The directions of a touch at an offset from the centre of a region with a radius: right, up, left, down as bits 0 to 3.
fn directions(own: &Dpad, [x, y]: PointMm, radius_mm: f64) -> u8 {
    let distance = libm::sqrt(x * x + y * y);
    if distance == 0.0 || distance < own.dead_zone * radius_mm {
        return 0;
    }
    let quarter = core::f64::consts::FRAC_PI_2;
    let angle = libm::atan2(y, x);
    let nearest = libm::round(angle / quarter);
    let off = angle - nearest * quarter;
    let main = (nearest as i64).rem_euclid(4) as u8;
    // At 1 diagonals take everything except the axes themselves, at 0 nothing.
    let is_diagonal =
        own.ways == 8 && own.diagonal > 0.0 && off.abs() > quarter / 2.0 * (1.0 - own.diagonal);
    if !is_diagonal {
        return 1 << main;
    }
    let other = if off > 0.0 {
        (main + 1) % 4
    } else {
        (main + 3) % 4
    };
    1 << main | 1 << other
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pad(ways: u8, diagonal: f64) -> Dpad {
        Dpad {
            ways,
            dead_zone: 0.2,
            diagonal,
            targets: [None; 4],
        }
    }

    #[test]
    fn four_ways_have_no_diagonals() {
        assert_eq!(directions(&pad(4, 0.5), [10.0, 9.0], 20.0), 0b0001);
        assert_eq!(directions(&pad(4, 0.5), [-9.0, 10.0], 20.0), 0b0010);
        assert_eq!(directions(&pad(4, 0.5), [-10.0, -9.0], 20.0), 0b0100);
        assert_eq!(directions(&pad(4, 0.5), [0.0, -10.0], 20.0), 0b1000);
    }

    #[test]
    fn diagonals_are_as_wide_as_asked() {
        assert_eq!(directions(&pad(8, 0.5), [10.0, 9.0], 20.0), 0b0011);
        assert_eq!(directions(&pad(8, 0.5), [10.0, -9.0], 20.0), 0b1001);
        assert_eq!(directions(&pad(8, 0.5), [10.0, 3.0], 20.0), 0b0001);
        assert_eq!(directions(&pad(8, 1.0), [10.0, 1.0], 20.0), 0b0011);
        assert_eq!(directions(&pad(8, 0.0), [10.0, 9.9], 20.0), 0b0001);
        assert_eq!(directions(&pad(8, 0.5), [-10.0, -10.0], 20.0), 0b1100);
    }

    #[test]
    fn the_middle_is_dead_up_to_its_edge() {
        assert_eq!(directions(&pad(4, 0.5), [3.9, 0.0], 20.0), 0);
        assert_eq!(directions(&pad(4, 0.5), [4.0, 0.0], 20.0), 1);
        assert_eq!(directions(&pad(4, 0.5), [0.0, 0.0], 0.0), 0);
    }
}
