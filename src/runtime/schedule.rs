//! When an event goes out: at its due time, and never so close behind the one before that a game misses either.
//!
//! ```text
//! due    __/~~~\______     a press that goes out late (the computer was busy) is still held for as
//! sent   ______/~~~\__     long as it was meant to, two frames of a game at most
//! ```
//! So is the gap before the next press of the same key. Other keys do not wait for that, as long as what is sent means the same:
//! the changes of one key stay in order, so do presses, and nothing passes a modifier. What became of an event is never
//! folded back into the engine.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::types::{Action, Event, Key, Nanos, Output};

/// Two frames of a game that runs at 60 Hz, ms: a game that polls sees what lasts so long.
pub(super) const SEEN: Duration = Duration::from_millis(34);
/// What goes out so much after its due time is late: a quarter of a game's frame.
pub(super) const LATE: Duration = Duration::from_millis(4);

/// An event on its way to the device.
#[derive(Clone, Copy, Debug)]
pub(super) struct Due {
    pub(super) event: Event,
    /// When it is due, by the clock.
    pub(super) at: Instant,
    /// When the engine had made it.
    pub(super) made: Instant,
    /// Arrival of the frame that caused it; none for a tick.
    pub(super) frame_at: Option<Instant>,
    /// Whether it is the last that follows from one input of the engine.
    pub(super) ends_batch: bool,
}

/// Events that wait for their time.
#[derive(Debug, Default)]
pub(super) struct Schedule {
    /// The batch that is not yet whole.
    partial: Vec<Due>,
    waiting: VecDeque<Due>,
    /// The last change of each output that went out.
    changes: Vec<Change>,
}

#[derive(Clone, Copy, Debug)]
struct Change {
    output: Output,
    sent: Instant,
    t_ns: Nanos,
}

impl Schedule {
    /// Takes an event; it can go out once its batch is whole.
    pub(super) fn take(&mut self, due: Due) {
        self.partial.push(due);
        if due.ends_batch {
            self.whole();
        }
    }

    /// Nothing more will come: what is there is whole.
    pub(super) fn whole(&mut self) {
        self.waiting.extend(self.partial.drain(..));
    }

    /// How many wait.
    pub(super) fn len(&self) -> usize {
        self.partial.len() + self.waiting.len()
    }

    /// The next event that may go out now, and when it should have.
    pub(super) fn next(&mut self, now: Instant) -> Option<(Due, Instant)> {
        let (index, at) = self.ready().find(|(_, at)| *at <= now)?;
        let due = self.waiting.remove(index)?;
        if let Some(output) = output_of(&due.event) {
            let change = Change {
                output,
                sent: now,
                t_ns: due.event.t_ns,
            };
            match self.changes.iter_mut().find(|c| c.output == output) {
                Some(known) => *known = change,
                None => self.changes.push(change),
            }
        }
        Some((due, at))
    }

    /// When the next event may go out.
    pub(super) fn next_at(&self) -> Option<Instant> {
        self.ready().map(|(_, at)| at).min()
    }

    /// Events that need not wait for one before them, and when each may go out.
    fn ready(&self) -> impl Iterator<Item = (usize, Instant)> + '_ {
        self.waiting.iter().enumerate().filter_map(|(index, due)| {
            let mut before = self.waiting.iter().take(index);
            if before.any(|one| keeps_waiting(&one.event, &due.event)) {
                return None;
            }
            let output = output_of(&due.event);
            let mut changes = self.changes.iter();
            let change = changes.find(|change| Some(change.output) == output);
            let clear = change.map_or(due.at, |change| {
                let meant = Duration::from_nanos(due.event.t_ns.saturating_sub(change.t_ns));
                change.sent + meant.min(SEEN)
            });
            Some((index, due.at.max(clear)))
        })
    }
}

/// Whether the second event must not go out before the first.
fn keeps_waiting(first: &Event, second: &Event) -> bool {
    let [one, other] = [first, second].map(output_of);
    let is_modifier = |output| matches!(output, Some(Output::Key(key)) if Key::is_modifier(key));
    let is_press = |event: &Event| matches!(event.action, Action::Press(_) | Action::Wheel { .. });
    (one.is_some() && one == other)
        || is_modifier(one)
        || is_modifier(other)
        || (is_press(first) && is_press(second))
}

fn output_of(event: &Event) -> Option<Output> {
    match event.action {
        Action::Press(output) | Action::Release(output) => Some(output),
        Action::Axis(..) | Action::Motion { .. } | Action::Wheel { .. } => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// A schedule, and a clock that shows the time only when it is told.
    struct Bench {
        schedule: Schedule,
        start: Instant,
    }

    impl Bench {
        #[allow(clippy::disallowed_methods, reason = "any instant will do")]
        fn new() -> Self {
            Self {
                schedule: Schedule::default(),
                start: Instant::now(),
            }
        }

        fn at(&self, ms: u64) -> Instant {
            self.start + Duration::from_millis(ms)
        }

        /// An event of the source's time `t_ms`, whose time has come by the clock then too.
        fn take(&mut self, t_ms: u64, text: &str, ends_batch: bool) {
            let (action, output) = text.split_once(' ').expect("an action");
            let output: Output = output.parse().expect("an output");
            let action = match action {
                "press" => Action::Press(output),
                _ => Action::Release(output),
            };
            let at = self.at(t_ms);
            self.schedule.take(Due {
                event: Event {
                    t_ns: t_ms * MS,
                    action,
                },
                at,
                made: at,
                frame_at: None,
                ends_batch,
            });
        }

        /// What goes out at a time.
        fn sent(&mut self, ms: u64) -> Vec<String> {
            let now = self.at(ms);
            let next = || self.schedule.next(now);
            let sent = std::iter::from_fn(next);
            sent.map(|(due, _)| due.event.to_string()).collect()
        }
    }

    #[test]
    fn what_is_in_time_goes_out_at_once() {
        let mut bench = Bench::new();
        bench.take(100, "press key:f", true);
        assert_eq!(bench.sent(100), ["100.000 press key:f"]);
        bench.take(134, "release key:f", true);
        assert_eq!(bench.sent(134), ["134.000 release key:f"]);
    }

    #[test]
    fn a_press_that_went_out_late_is_held_for_two_frames_and_others_do_not_wait() {
        let mut bench = Bench::new();
        bench.take(100, "press key:f", true);
        bench.take(150, "release key:f", true);
        bench.take(150, "press key:d", true);
        bench.take(190, "press key:f", true);
        // The computer slept for 200 ms.
        assert_eq!(
            bench.sent(300),
            ["100.000 press key:f", "150.000 press key:d"]
        );
        assert_eq!(bench.schedule.next_at(), Some(bench.at(334)));
        assert!(bench.sent(333).is_empty());
        assert_eq!(bench.sent(334), ["150.000 release key:f"]);
        assert!(bench.sent(367).is_empty());
        assert_eq!(bench.sent(368), ["190.000 press key:f"]);
        assert_eq!(bench.schedule.len(), 0);
    }

    #[test]
    fn a_press_shorter_than_two_frames_stays_as_short_as_it_was_meant() {
        let mut bench = Bench::new();
        bench.take(100, "press key:f", true);
        bench.take(110, "release key:f", true);
        assert_eq!(bench.sent(150), ["100.000 press key:f"]);
        assert_eq!(bench.sent(160), ["110.000 release key:f"]);
    }

    #[test]
    fn nothing_passes_a_modifier_and_presses_stay_in_order() {
        let mut bench = Bench::new();
        bench.take(100, "press key:left-ctrl", true);
        bench.take(100, "press key:c", true);
        bench.take(140, "release key:c", true);
        bench.take(140, "release key:left-ctrl", true);
        bench.take(140, "press key:v", true);
        bench.take(180, "press key:c", true);
        bench.take(180, "press key:x", true);
        assert_eq!(
            bench.sent(300),
            ["100.000 press key:left-ctrl", "100.000 press key:c"]
        );
        assert_eq!(
            bench.sent(334),
            [
                "140.000 release key:c",
                "140.000 release key:left-ctrl",
                "140.000 press key:v"
            ]
        );
        assert!(bench.sent(367).is_empty());
        assert_eq!(
            bench.sent(368),
            ["180.000 press key:c", "180.000 press key:x"]
        );
    }

    #[test]
    fn half_a_batch_waits_for_its_end() {
        let mut bench = Bench::new();
        bench.take(100, "press key:f", false);
        assert!(bench.sent(101).is_empty());
        bench.take(100, "press key:d", true);
        assert_eq!(
            bench.sent(102),
            ["100.000 press key:f", "100.000 press key:d"]
        );
        bench.take(200, "release key:f", false);
        assert!(bench.sent(201).is_empty());
        // The engine is gone.
        bench.schedule.whole();
        assert_eq!(bench.sent(202), ["200.000 release key:f"]);
    }
}
