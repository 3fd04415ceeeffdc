//! Makes frame times from a board's clock and the times of arrival.
//!
//! Arrival times jitter: USB adapters collect bytes for up to 16 ms, and the system delivers them with a delay. The
//! board's clock does not jitter, but it starts anywhere, overflows, drifts, and restarts when the board is reset. So the
//! time of a frame is the board's time, unwrapped and shifted by the shortest delay of the last second: steps between
//! frames are those of the board, and in the long run time follows the computer's clock. After an impossible jump the
//! frame gets its time of arrival, and the offset starts again from there.
//!
//! Invariant: times never run backwards.

use std::time::Instant;

use super::wire::Stamp;
use crate::types::{NANOS_PER_MS, Nanos};

/// Time over which the shortest delay is determined.
const WINDOW_NS: Nanos = 1000 * NANOS_PER_MS;
/// Largest difference between the board's time and the arrival; a larger one means that one of them jumped.
const LARGEST_DIFFERENCE_NS: i128 = 250 * NANOS_PER_MS as i128;

/// The computer's clock: the only one that sources read.
#[allow(clippy::disallowed_methods, reason = "devices are timed by the clock")]
pub(super) fn now() -> Instant {
    Instant::now()
}

/// Determines the time of each frame.
#[derive(Clone, Debug, Default)]
pub(super) struct DeviceClock {
    offset: Option<ClockOffset>,
    last_ns: Nanos,
}

/// The offset between the board's time and the time of arrival.
#[derive(Clone, Copy, Debug)]
struct ClockOffset {
    ticks: u32,
    /// The board's time since the offset was determined, ns.
    device_ns: i128,
    /// Added to it to get the frame's time.
    offset_ns: i128,
    window_from: Nanos,
    /// Shortest delay in this window.
    shortest_ns: i128,
}

impl DeviceClock {
    /// The time of a frame, from its stamp and its arrival.
    pub(super) fn frame_time(&mut self, stamp: Option<Stamp>, arrived_ns: Nanos) -> Nanos {
        let t_ns = match stamp {
            Some(stamp) => self.time_of_stamp(stamp, arrived_ns),
            None => arrived_ns,
        };
        self.last_ns = self.last_ns.max(t_ns);
        self.last_ns
    }

    /// The board was disconnected: its clock may restart.
    pub(super) fn reset(&mut self) {
        self.offset = None;
    }

    fn time_of_stamp(&mut self, stamp: Stamp, arrived_ns: Nanos) -> Nanos {
        let arrived = i128::from(arrived_ns);
        let fresh = ClockOffset {
            ticks: stamp.ticks,
            device_ns: 0,
            offset_ns: arrived,
            window_from: arrived_ns,
            shortest_ns: 0,
        };
        let offset = self.offset.get_or_insert(fresh);
        // The wrapping difference is right across an overflow; a clock that went back shows as a large step ahead.
        let ticks = stamp.ticks.wrapping_sub(offset.ticks);
        offset.ticks = stamp.ticks;
        offset.device_ns += i128::from(ticks) * i128::from(stamp.tick_ns);
        let delay = arrived - (offset.device_ns + offset.offset_ns);
        if delay.abs() > LARGEST_DIFFERENCE_NS {
            *offset = fresh;
            return arrived_ns;
        }
        if delay < 0 {
            // A frame cannot arrive before it was measured.
            offset.offset_ns += delay;
            offset.shortest_ns = 0;
        }
        offset.shortest_ns = offset.shortest_ns.min(delay.max(0));
        if arrived_ns.saturating_sub(offset.window_from) >= WINDOW_NS {
            offset.offset_ns += offset.shortest_ns;
            offset.window_from = arrived_ns;
            offset.shortest_ns = LARGEST_DIFFERENCE_NS;
        }
        Nanos::try_from(offset.device_ns + offset.offset_ns).unwrap_or(arrived_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Nanos = NANOS_PER_MS;

    fn stamp(us: u64) -> Option<Stamp> {
        Some(Stamp {
            ticks: us as u32,
            tick_ns: 1000,
        })
    }

    #[test]
    fn frames_that_arrive_in_bursts_keep_the_steps_of_the_board() {
        let mut clock = DeviceClock::default();
        // The adapter delivers every 16 ms; the count overflows on the way.
        let start = u64::from(u32::MAX) - 500_000;
        let times: Vec<Nanos> = (0..1000_u64)
            .map(|n| {
                let measured = n * 2 * MS;
                let arrived = (measured / (16 * MS) + 1) * 16 * MS;
                clock.frame_time(stamp(start + n * 2000), arrived)
            })
            .collect();
        // From the second burst on all delays are known to be shorter than the first one.
        for pair in times[8..].windows(2) {
            let step = pair[1] - pair[0];
            assert!((2 * MS..2 * MS + MS / 10).contains(&step), "{step}");
        }
    }

    #[test]
    fn a_drifting_clock_follows_the_computers() {
        let mut clock = DeviceClock::default();
        for n in 0..100_000_u64 {
            let arrived = n * 10 * MS;
            // 200 ppm slow: after 1000 s the board is 200 ms behind.
            let measured_us = n * 10_000 * 9998 / 10_000;
            let t_ns = clock.frame_time(stamp(measured_us), arrived);
            assert!(arrived - t_ns < MS, "{n}: {}", arrived - t_ns);
        }
    }

    #[test]
    fn times_never_run_backwards_after_a_reset_or_with_a_broken_clock() {
        let mut clock = DeviceClock::default();
        let mut last = 0;
        for (n, us) in [10_000, 20_000, 30_000, 0, 10_000, 4_000_000_000, 5, 17]
            .into_iter()
            .enumerate()
        {
            let arrived = 100 * MS + n as Nanos * 10 * MS;
            let t_ns = clock.frame_time(stamp(us), arrived);
            assert!(t_ns >= last);
            assert!(t_ns.abs_diff(arrived) <= 250 * MS, "{n}");
            last = t_ns;
        }
    }
}
