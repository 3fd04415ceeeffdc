//! Compares the recorded touches and events with those of the replay.

use std::collections::VecDeque;

use crate::engine::Input;
use crate::session::Touches;
use crate::tape::RecordedTouches;
use crate::types::{Event, Nanos, Touch};

/// Items by which recording and replay may be apart: at most a compressed block and its results.
const MAX_LAG: usize = 1 << 16;

/// Compares incrementally.
#[derive(Default)]
pub(super) struct Verify {
    events: Comparison<String>,
    touches: Comparison<(Nanos, u32)>,
    recorded: RecordedTouches,
}

impl Verify {
    /// Adds the results of a replayed input.
    pub(super) fn add_replayed(&mut self, input: &Input, down: &[Touch], events: &[Event]) {
        for event in events {
            self.events.add_replayed(exact_text(event));
        }
        if let Some(touches) = self.recorded.after(input, down) {
            self.touches.add_replayed((touches.t_ns, touches.sum));
        }
    }

    /// Adds a recorded event.
    pub(super) fn add_recorded_event(&mut self, event: &Event) {
        self.events.add_recorded(exact_text(event));
    }

    /// Adds recorded touches.
    pub(super) fn add_recorded_touches(&mut self, touches: &Touches) {
        self.touches.add_recorded((touches.t_ns, touches.sum));
    }

    /// Describes the first difference: that of the events, or that of the touches if the events are the same. A recorded item without a replayed one counts; the reverse, after a truncated
    /// recording, does not.
    pub(super) fn first_difference(&self) -> Option<String> {
        let or_nothing = |event: &Option<String>| event.clone().unwrap_or("nothing".to_owned());
        let event = self.events.difference().map(|(recorded, replayed)| {
            format!(
                "recorded `{}`, replayed `{}`",
                or_nothing(&recorded),
                or_nothing(&replayed)
            )
        });
        event.or_else(|| {
            let (recorded, replayed) = self.touches.difference()?;
            let (t_ns, _) = recorded.or(replayed)?;
            let at_ms = crate::types::ms_from_nanos(t_ns);
            // The events are the same, so the touches are nearly.
            let how = match replayed {
                Some(_) => "differ in their last bits",
                None => "are missing",
            };
            Some(format!("the touches at {at_ms:.3} ms {how}"))
        })
    }
}

/// An event with all its bits.
fn exact_text(event: &Event) -> String {
    match event.action {
        crate::types::Action::Axis(_, value) => {
            format!("{event} ({:08x} at {} ns)", value.to_bits(), event.t_ns)
        }
        _ if event.t_ns.is_multiple_of(1000) => event.to_string(),
        _ => format!("{event} (at {} ns)", event.t_ns),
    }
}

/// Two sequences that should be equal.
struct Comparison<T> {
    recorded: VecDeque<T>,
    replayed: VecDeque<T>,
    first: Option<(Option<T>, Option<T>)>,
}

impl<T> Default for Comparison<T> {
    fn default() -> Self {
        Self {
            recorded: VecDeque::new(),
            replayed: VecDeque::new(),
            first: None,
        }
    }
}

impl<T: PartialEq + Clone> Comparison<T> {
    fn add_recorded(&mut self, item: T) {
        self.recorded.push_back(item);
        self.compare();
    }

    fn add_replayed(&mut self, item: T) {
        self.replayed.push_back(item);
        self.compare();
    }

    fn compare(&mut self) {
        while let (Some(recorded), Some(replayed)) = (self.recorded.front(), self.replayed.front())
        {
            if recorded != replayed && self.first.is_none() {
                self.first = Some((Some(recorded.clone()), Some(replayed.clone())));
            }
            self.recorded.pop_front();
            self.replayed.pop_front();
        }
        for queue in [&mut self.recorded, &mut self.replayed] {
            if queue.len() > MAX_LAG {
                queue.pop_front();
            }
        }
    }

    fn difference(&self) -> Option<(Option<T>, Option<T>)> {
        let left = || {
            self.recorded
                .front()
                .map(|recorded| (Some(recorded.clone()), None))
        };
        self.first.clone().or_else(left)
    }
}
