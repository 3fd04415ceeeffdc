//! A swipe: a stroke of a length in one direction, done within a time. It is one as soon as it is long enough, and
//! its output stays down until the touch lifts.
//!
//! ```text
//! way      0 .... 15 mm ......
//! touch    ____/~~~~~~~~~~\____
//! output   _________/~~~~~\____
//! ```

use crate::profile::Swipe;
use crate::types::{Nanos, PointMm};

/// Touches that may become a swipe.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stroke {
    /// Begun there and then.
    Open { from_mm: PointMm, since_ns: Nanos },
    /// It is one.
    Done,
    /// Too slow, or another way.
    Missed,
}

impl Stroke {
    /// The touches are there now; returns whether this makes it a swipe.
    pub(super) fn moved(&mut self, own: &Swipe, at_mm: PointMm, t_ns: Nanos) -> bool {
        let Self::Open { from_mm, since_ns } = *self else {
            return false;
        };
        let way = [at_mm[0] - from_mm[0], at_mm[1] - from_mm[1]];
        if t_ns >= since_ns + own.within_ns {
            *self = Self::Missed;
            return false;
        }
        if libm::sqrt(way[0] * way[0] + way[1] * way[1]) < own.distance_mm {
            return false;
        }
        let is_one = eighth(way, own.ways) == own.direction.eighth;
        *self = if is_one { Self::Done } else { Self::Missed };
        is_one
    }
}

/// The direction of a way, in eighths of a turn from the right; of 4 or 8 directions, the nearest.
pub(super) fn eighth([x, y]: PointMm, ways: u8) -> u8 {
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
