//! A swipe: a stroke of a length in one direction, done within a time. It is recognized as soon as it is long enough, and
//! its output stays down until the touch lifts. Several fingers are followed at their centroid.
//!
//! ```text
//! way      0 .... 15 mm ......
//! touch    ____/~~~~~~~~~~\____
//! output   _________/~~~~~\____
//! ```

use super::recognizer::{Playing, Recognizer, TouchGroup};
use crate::gesture::driver::TargetSet;
use crate::gesture::fingers::TouchSample;
use crate::profile::Swipe;
use crate::types::{Nanos, PointMm};

/// A touch that may become a swipe.
#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) enum SwipeRecognizer {
    /// Began there and then.
    Open { from_mm: PointMm, since_ns: Nanos },
    /// Is a swipe, was too slow, or went another way.
    Decided,
}

impl Recognizer for SwipeRecognizer {
    type Gesture = Swipe;

    fn is_group(own: &Swipe) -> bool {
        own.fingers > 1
    }

    fn is_complete(own: &Swipe, group: &TouchGroup<'_>) -> bool {
        group.fingers.count(group.regions) == own.fingers
    }

    fn down(_own: &Swipe, touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self {
        Self::Open {
            from_mm: touch.at_mm,
            since_ns: playing.t_ns(),
        }
    }

    fn moved(&mut self, own: &Swipe, touch: &TouchSample, playing: &mut Playing<'_, '_>) {
        let Self::Open { from_mm, since_ns } = *self else {
            return;
        };
        if playing.t_ns() >= since_ns + own.within_ns {
            *self = Self::Decided;
            return;
        }
        let way_mm = [0, 1].map(|i| touch.at_mm[i] - from_mm[i]);
        if libm::sqrt(way_mm[0] * way_mm[0] + way_mm[1] * way_mm[1]) < own.distance_mm {
            return;
        }
        *self = Self::Decided;
        if eighth(way_mm, own.ways) == own.direction.eighth {
            playing.press(TargetSet::Main);
        }
    }
}

/// The nearest of 4 or 8 directions, in eighths of a turn from the right.
fn eighth([x, y]: PointMm, ways: u8) -> u8 {
    let ways = f64::from(ways);
    let turns = libm::atan2(y, x) / core::f64::consts::TAU;
    let nearest = libm::round(turns * ways);
    let eighth = libm::round(nearest * 8.0 / ways) as i64;
    eighth.rem_euclid(8) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_the_nearest_ones() {
        assert_eq!(eighth([1.0, 0.1], 4), 0);
        assert_eq!(eighth([1.0, 0.9], 4), 0);
        assert_eq!(eighth([1.0, 0.9], 8), 1);
        assert_eq!(eighth([0.1, 1.0], 8), 2);
        assert_eq!(eighth([-1.0, 0.0], 8), 4);
        assert_eq!(eighth([-1.0, -0.1], 4), 4);
        assert_eq!(eighth([0.0, -1.0], 4), 6);
        assert_eq!(eighth([1.0, -1.0], 8), 7);
    }
}
