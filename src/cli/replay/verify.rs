//! What a recording says came of its inputs against what comes of them now.

use std::collections::VecDeque;

use crate::engine::Input;
use crate::session::{Touches, touches_sum};
use crate::types::{Event, Nanos, Touch};

/// What is recorded and replayed may be so many things apart: a packed block and what came of it.
const MOST_APART: usize = 1 << 16;

/// Compares as both come along.
#[derive(Default)]
pub(super) struct Verify {
    events: Pairs<String>,
    touches: Pairs<(Nanos, u32)>,
    had_touches: bool,
}

impl Verify {
    /// Takes what came of an input.
    pub(super) fn replayed(&mut self, input: &Input, down: &[Touch], events: &[Event]) {
        for event in events {
            self.events.replayed(exact(event));
        }
        if let Input::Frame(frame) = input {
            if self.had_touches || !down.is_empty() {
                self.touches.replayed((frame.t_ns, touches_sum(down)));
            }
            self.had_touches = !down.is_empty();
        }
    }

    /// Takes what came of it then.
    pub(super) fn recorded_event(&mut self, event: &Event) {
        self.events.recorded(exact(event));
    }

    /// Takes what came of it then.
    pub(super) fn recorded_touches(&mut self, touches: &Touches) {
        self.touches.recorded((touches.t_ns, touches.sum));
    }

    /// Where they differ first, in words. What was recorded and did not come again counts too; what was cut off does not.
    pub(super) fn first_difference(&self) -> Option<String> {
        let or_nothing = |event: &Option<String>| event.clone().unwrap_or("nothing".to_owned());
        let event = self
            .events
            .difference()
            .map(|(was, is)| format!("it was `{}`, it is `{}`", or_nothing(&was), or_nothing(&is)));
        event.or_else(|| {
            let (was, is) = self.touches.difference()?;
            let (t_ns, _) = was.or(is)?;
            Some(format!(
                "the touches at {:.3} ms differ in their last bits",
                crate::types::ms_from_nanos(t_ns)
            ))
        })
    }
}

/// An event to the bit.
fn exact(event: &Event) -> String {
    match event.action {
        crate::types::Action::Axis(_, value) => {
            format!("{event} ({:08x} at {} ns)", value.to_bits(), event.t_ns)
        }
        _ if event.t_ns.is_multiple_of(1000) => event.to_string(),
        _ => format!("{event} (at {} ns)", event.t_ns),
    }
}

/// Two rows that should be the same.
struct Pairs<T> {
    recorded: VecDeque<T>,
    replayed: VecDeque<T>,
    first: Option<(Option<T>, Option<T>)>,
}

impl<T> Default for Pairs<T> {
    fn default() -> Self {
        Self {
            recorded: VecDeque::new(),
            replayed: VecDeque::new(),
            first: None,
        }
    }
}

impl<T: PartialEq + Clone> Pairs<T> {
    fn recorded(&mut self, item: T) {
        self.recorded.push_back(item);
        self.compare();
    }

    fn replayed(&mut self, item: T) {
        self.replayed.push_back(item);
        self.compare();
    }

    fn compare(&mut self) {
        while let (Some(was), Some(is)) = (self.recorded.front(), self.replayed.front()) {
            if was != is && self.first.is_none() {
                self.first = Some((Some(was.clone()), Some(is.clone())));
            }
            self.recorded.pop_front();
            self.replayed.pop_front();
        }
        for queue in [&mut self.recorded, &mut self.replayed] {
            if queue.len() > MOST_APART {
                queue.pop_front();
            }
        }
    }

    fn difference(&self) -> Option<(Option<T>, Option<T>)> {
        let left = || self.recorded.front().map(|was| (Some(was.clone()), None));
        self.first.clone().or_else(left)
    }
}
