//! Decides when an event is sent: at its due time, but not so soon after the previous change of the same
//! output that a game would miss one of them.
//!
//! ```text
//! due    __/~~~\______     a press that is sent late (the computer was busy) is still held as
//! sent   ______/~~~\__     long as intended, but at most for two frames of a game
//! ```
//! The gap before the next press of the same key is kept in the same way. Events of other keys need not wait for it,
//! except that presses stay in order and nothing passes a modifier key. The engine never learns of these delays.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::types::{Action, Event, Key, Nanos, Output};

/// Two frames of a game at 60 Hz: a game that polls sees a change that lasts this long.
pub(super) const LONGEST_KEPT_GAP: Duration = Duration::from_millis(34);
/// An event sent later than this after its due time counts as late: a quarter of a game's frame.
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
    /// Whether it is the last event of its input of the engine.
    pub(super) ends_batch: bool,
}

/// Events that wait for their due time.
#[derive(Debug, Default)]
pub(super) struct Schedule {
    /// The batch that is not complete yet.
    partial: Vec<Due>,
    waiting: VecDeque<Due>,
    /// The last change of each output that was sent.
    changes: Vec<LastChange>,
}

#[derive(Clone, Copy, Debug)]
struct LastChange {
    output: Output,
    sent: Instant,
    t_ns: Nanos,
}

impl Schedule {
    /// Adds an event; it can be sent once its batch is complete.
    pub(super) fn add(&mut self, due: Due) {
        self.partial.push(due);
        if due.ends_batch {
            self.end_batch();
        }
    }

    /// Completes the batch, also when the engine has ended within one.
    pub(super) fn end_batch(&mut self) {
        self.waiting.extend(self.partial.drain(..));
    }

    /// Number of waiting events.
    pub(super) fn len(&self) -> usize {
        self.partial.len() + self.waiting.len()
    }

    /// The next event that may be sent now, and when it was due.
    pub(super) fn next(&mut self, now: Instant) -> Option<(Due, Instant)> {
        let (index, at) = self.ready().find(|(_, at)| *at <= now)?;
        let due = self.waiting.remove(index)?;
        if let Some(output) = output_of(&due.event) {
            let change = LastChange {
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

    /// When the next event may be sent.
    pub(super) fn next_at(&self) -> Option<Instant> {
        self.ready().map(|(_, at)| at).min()
    }

    /// Events that need not wait for an earlier one, and when each may be sent.
    fn ready(&self) -> impl Iterator<Item = (usize, Instant)> + '_ {
        self.waiting.iter().enumerate().filter_map(|(index, due)| {
            let mut before = self.waiting.iter().take(index);
            if before.any(|one| must_follow(&one.event, &due.event)) {
                return None;
            }
            let output = output_of(&due.event);
            let mut changes = self.changes.iter();
            let change = changes.find(|change| Some(change.output) == output);
            let earliest = change.map_or(due.at, |change| {
                let intended = Duration::from_nanos(due.event.t_ns.saturating_sub(change.t_ns));
                change.sent + intended.min(LONGEST_KEPT_GAP)
            });
            Some((index, due.at.max(earliest)))
        })
    }
}

/// Whether the second event must not be sent before the first.
fn must_follow(first: &Event, second: &Event) -> bool {
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

    /// A schedule with a clock that the test sets.
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

        /// Adds an event that is due at `t_ms`, by the source's time and by the clock.
        fn add(&mut self, t_ms: u64, text: &str, ends_batch: bool) {
            let (action, output) = text.split_once(' ').expect("an action");
            let output: Output = output.parse().expect("an output");
            let action = match action {
                "press" => Action::Press(output),
                _ => Action::Release(output),
            };
            let at = self.at(t_ms);
            self.schedule.add(Due {
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

        /// The events sent at a time.
        fn sent(&mut self, ms: u64) -> Vec<String> {
            let now = self.at(ms);
            let next = || self.schedule.next(now);
            let sent = std::iter::from_fn(next);
            sent.map(|(due, _)| due.event.to_string()).collect()
        }
    }

    #[test]
    fn events_on_time_are_sent_immediately() {
        let mut bench = Bench::new();
        bench.add(100, "press key:f", true);
        assert_eq!(bench.sent(100), ["100.000 press key:f"]);
        bench.add(134, "release key:f", true);
        assert_eq!(bench.sent(134), ["134.000 release key:f"]);
    }

    #[test]
    fn a_late_press_is_held_for_two_frames_and_other_keys_do_not_wait() {
        let mut bench = Bench::new();
        bench.add(100, "press key:f", true);
        bench.add(150, "release key:f", true);
        bench.add(150, "press key:d", true);
        bench.add(190, "press key:f", true);
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
    fn a_press_shorter_than_two_frames_keeps_its_length() {
        let mut bench = Bench::new();
        bench.add(100, "press key:f", true);
        bench.add(110, "release key:f", true);
        assert_eq!(bench.sent(150), ["100.000 press key:f"]);
        assert_eq!(bench.sent(160), ["110.000 release key:f"]);
    }

    #[test]
    fn nothing_passes_a_modifier_and_presses_stay_in_order() {
        let mut bench = Bench::new();
        bench.add(100, "press key:left-ctrl", true);
        bench.add(100, "press key:c", true);
        bench.add(140, "release key:c", true);
        bench.add(140, "release key:left-ctrl", true);
        bench.add(140, "press key:v", true);
        bench.add(180, "press key:c", true);
        bench.add(180, "press key:x", true);
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
    fn an_incomplete_batch_waits_for_its_end() {
        let mut bench = Bench::new();
        bench.add(100, "press key:f", false);
        assert!(bench.sent(101).is_empty());
        bench.add(100, "press key:d", true);
        assert_eq!(
            bench.sent(102),
            ["100.000 press key:f", "100.000 press key:d"]
        );
        bench.add(200, "release key:f", false);
        assert!(bench.sent(201).is_empty());
        // The engine has ended.
        bench.schedule.end_batch();
        assert_eq!(bench.sent(202), ["200.000 release key:f"]);
    }
}
