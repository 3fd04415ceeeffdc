//! A board's own time, made the time of frames.
//!
//! Arrival times jitter: USB adapters collect bytes for up to 16 ms, the system delivers them when it likes. The board's clock
//! does not, but it counts from anywhere, runs over, drifts, and starts anew when the board is reset. So a frame's time is
//! the board's, unwrapped and shifted by the shortest delay that the last second showed: steps between frames are the
//! board's, and in the long run time goes as the computer's does. A clock that says something impossible is not believed:
//! the frame gets its time of arrival, and the board's clock is tied anew.
//!
//! Invariant: times never run backwards.

use super::wire::Stamp;
use crate::types::{NANOS_PER_MS, Nanos};

/// Over so long the shortest delay is looked for.
const WINDOW_NS: Nanos = 1000 * NANOS_PER_MS;
/// Board and arrival differ by no more; else one of them jumped.
const MOST_APART_NS: i128 = 250 * NANOS_PER_MS as i128;

/// Gives frames their times.
#[derive(Clone, Debug, Default)]
pub(super) struct DeviceClock {
    tied: Option<Tied>,
    last_ns: Nanos,
}

/// How the board's time is tied to that of arrivals.
#[derive(Clone, Copy, Debug)]
struct Tied {
    ticks: u32,
    /// The board's time since it was tied, ns.
    device_ns: i128,
    /// What is added to it.
    offset_ns: i128,
    window_from: Nanos,
    /// Shortest delay of this window.
    shortest_ns: i128,
}

impl DeviceClock {
    /// The time of a frame that arrived at a time.
    pub(super) fn time(&mut self, stamp: Option<Stamp>, arrived_ns: Nanos) -> Nanos {
        let t_ns = match stamp {
            Some(stamp) => self.by_device(stamp, arrived_ns),
            None => arrived_ns,
        };
        self.last_ns = self.last_ns.max(t_ns);
        self.last_ns
    }

    /// The board went away: its clock may start anew.
    pub(super) fn untie(&mut self) {
        self.tied = None;
    }

    fn by_device(&mut self, stamp: Stamp, arrived_ns: Nanos) -> Nanos {
        let arrived = i128::from(arrived_ns);
        let fresh = Tied {
            ticks: stamp.ticks,
            device_ns: 0,
            offset_ns: arrived,
            window_from: arrived_ns,
            shortest_ns: 0,
        };
        let tied = self.tied.get_or_insert(fresh);
        // The difference of two counts is right across the run-over; a clock that went back shows as a leap ahead.
        let ticks = stamp.ticks.wrapping_sub(tied.ticks);
        tied.ticks = stamp.ticks;
        tied.device_ns += i128::from(ticks) * i128::from(stamp.tick_ns);
        let delay = arrived - (tied.device_ns + tied.offset_ns);
        if delay.abs() > MOST_APART_NS {
            *tied = fresh;
            return arrived_ns;
        }
        if delay < 0 {
            // It cannot arrive before it was measured.
            tied.offset_ns += delay;
            tied.shortest_ns = 0;
        }
        tied.shortest_ns = tied.shortest_ns.min(delay.max(0));
        if arrived_ns.saturating_sub(tied.window_from) >= WINDOW_NS {
            tied.offset_ns += tied.shortest_ns;
            tied.window_from = arrived_ns;
            tied.shortest_ns = MOST_APART_NS;
        }
        Nanos::try_from(tied.device_ns + tied.offset_ns).unwrap_or(arrived_ns)
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
    fn frames_that_arrive_in_bursts_keep_the_boards_steps() {
        let mut clock = DeviceClock::default();
        // The adapter hands over every 16 ms; the count runs over on the way.
        let start = u64::from(u32::MAX) - 500_000;
        let times: Vec<Nanos> = (0..1000_u64)
            .map(|n| {
                let measured = n * 2 * MS;
                let arrived = (measured / (16 * MS) + 1) * 16 * MS;
                clock.time(stamp(start + n * 2000), arrived)
            })
            .collect();
        // From the second burst on all delays are known to be shorter than the first one's.
        for pair in times[8..].windows(2) {
            let step = pair[1] - pair[0];
            assert!((2 * MS..2 * MS + MS / 10).contains(&step), "{step}");
        }
    }

    #[test]
    fn a_clock_that_drifts_stays_with_the_computers() {
        let mut clock = DeviceClock::default();
        for n in 0..100_000_u64 {
            let arrived = n * 10 * MS;
            // Slow by 200 ppm: after 1000 s it is 200 ms behind.
            let measured_us = n * 10_000 * 9998 / 10_000;
            let t_ns = clock.time(stamp(measured_us), arrived);
            assert!(arrived - t_ns < MS, "{n}: {}", arrived - t_ns);
        }
    }

    #[test]
    fn a_reset_or_mad_clock_never_runs_backwards_or_away() {
        let mut clock = DeviceClock::default();
        let mut last = 0;
        for (n, us) in [10_000, 20_000, 30_000, 0, 10_000, 4_000_000_000, 5, 17]
            .into_iter()
            .enumerate()
        {
            let arrived = 100 * MS + n as Nanos * 10 * MS;
            let t_ns = clock.time(stamp(us), arrived);
            assert!(t_ns >= last);
            assert!(t_ns.abs_diff(arrived) <= 250 * MS, "{n}");
            last = t_ns;
        }
    }
}
