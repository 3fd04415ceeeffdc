//! The last five seconds, gathered from views: touches with their paths, presses of outputs. A view may skip frames; a path is
//! straight there.

use std::collections::VecDeque;

use crate::runtime::View;
use crate::types::{Action, NANOS_PER_MS, Nanos, Output, PointMm};

/// Length of the history.
pub const HISTORY_NS: Nanos = 5_000 * NANOS_PER_MS;
/// Points of a stroke: five seconds at 128 frames/s.
const MAX_POINTS: usize = 640;
/// Presses that are kept, older than five seconds too: the edit view shows the last one.
const MAX_PRESSES: usize = 64;

/// One point of a touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Time.
    pub t_ns: Nanos,
    /// Position on the pad, mm.
    pub place_mm: PointMm,
    /// Force, 0 to 1.
    pub force: f32,
}

/// A touch with its path.
#[derive(Clone, Debug)]
pub struct Stroke {
    /// The id of the touch.
    pub id: u64,
    /// When it went down.
    pub since_ns: Nanos,
    /// Whether it is still down.
    pub down: bool,
    /// Its points, oldest first.
    pub moments: VecDeque<Moment>,
}

/// A press of an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Press {
    /// The output.
    pub output: Output,
    /// Time of the press.
    pub from_ns: Nanos,
    /// Time of the release; none while it is down.
    pub until_ns: Option<Nanos>,
}

impl Press {
    /// How long it was down, or has been down until `now_ns`.
    pub fn length_ns(&self, now_ns: Nanos) -> Nanos {
        self.until_ns.unwrap_or(now_ns).saturating_sub(self.from_ns)
    }
}

/// Recent touches and presses.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// Time of the newest view.
    pub now_ns: Nanos,
    /// Touches, oldest first.
    pub strokes: VecDeque<Stroke>,
    /// Presses, oldest first.
    pub presses: VecDeque<Press>,
    /// Values of axes, newest last.
    pub axes: Vec<(crate::types::Axis, f32)>,
    events_seen: u64,
}

impl History {
    /// Adds what is new in a view.
    pub fn add_view(&mut self, view: &View) {
        if view.t_ns < self.now_ns || view.events_so_far < self.events_seen {
            // The source was restarted or changed.
            *self = Self::default();
        }
        self.now_ns = view.t_ns;
        self.add_touches(view);
        self.add_events(view);
        self.drop_old();
    }

    /// The newest press.
    pub fn last_press(&self) -> Option<&Press> {
        self.presses.back()
    }

    fn add_touches(&mut self, view: &View) {
        for stroke in &mut self.strokes {
            stroke.down &= view.touches.iter().any(|touch| touch.id.0 == stroke.id);
        }
        for touch in &view.touches {
            let moment = Moment {
                t_ns: view.t_ns,
                place_mm: touch.contact.centre_mm,
                force: touch.contact.force as f32,
            };
            let known = self.strokes.iter_mut().find(|s| s.id == touch.id.0);
            let stroke = match known {
                Some(stroke) => stroke,
                None => {
                    self.strokes.push_back(Stroke {
                        id: touch.id.0,
                        since_ns: touch.since_ns,
                        down: true,
                        moments: VecDeque::new(),
                    });
                    let last = self.strokes.len() - 1;
                    &mut self.strokes[last]
                }
            };
            if stroke.moments.back().is_none_or(|m| m.t_ns < moment.t_ns) {
                stroke.moments.push_back(moment);
            }
            if stroke.moments.len() > MAX_POINTS {
                stroke.moments.pop_front();
            }
        }
    }

    fn add_events(&mut self, view: &View) {
        let fresh = view.events_so_far - self.events_seen;
        let skip = (view.events.len() as u64).saturating_sub(fresh) as usize;
        self.events_seen = view.events_so_far;
        for event in view.events.iter().skip(skip) {
            match event.action {
                Action::Press(output) => self.presses.push_back(Press {
                    output,
                    from_ns: event.t_ns,
                    until_ns: None,
                }),
                Action::Release(output) => {
                    let open = self
                        .presses
                        .iter_mut()
                        .find(|press| press.output == output && press.until_ns.is_none());
                    if let Some(press) = open {
                        press.until_ns = Some(event.t_ns);
                    }
                }
                Action::Axis(axis, value) => {
                    self.axes.retain(|(known, _)| *known != axis);
                    self.axes.push((axis, value));
                }
                Action::Motion { .. } | Action::Wheel { .. } => {}
            }
        }
        // A release that no view contained: more events came than a view keeps.
        for press in &mut self.presses {
            if press.until_ns.is_none() && !view.held.contains(&press.output) {
                press.until_ns = Some(view.t_ns);
            }
        }
    }

    fn drop_old(&mut self) {
        let oldest_ns = self.now_ns.saturating_sub(HISTORY_NS);
        self.strokes
            .retain(|s| s.down || s.moments.back().is_some_and(|m| m.t_ns >= oldest_ns));
        while self.presses.len() > MAX_PRESSES {
            self.presses.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::still::{self, touch};
    use crate::types::Event;

    fn event(ms: u64, press: bool) -> Event {
        let output: Output = "key:f".parse().expect("a key");
        Event {
            t_ns: ms * NANOS_PER_MS,
            action: if press {
                Action::Press(output)
            } else {
                Action::Release(output)
            },
        }
    }

    #[test]
    fn the_length_of_a_press_comes_from_its_events() {
        let mut view = still::view();
        let mut history = History::default();
        view.t_ns = 1000 * NANOS_PER_MS;
        view.events = [event(900, true), event(980, false)].into();
        view.events_so_far = 2;
        history.add_view(&view);
        history.add_view(&view);
        let lengths: Vec<Nanos> = history.presses.iter().map(|p| p.length_ns(0)).collect();
        assert_eq!(lengths, [80 * NANOS_PER_MS]);
    }

    #[test]
    fn a_touch_keeps_its_path_for_five_seconds() {
        let mut view = still::view();
        let mut history = History::default();
        for ms in 0..10 {
            view.t_ns = ms * 10 * NANOS_PER_MS;
            view.touches = vec![touch(4, [ms as f64, 50.0], 0.5)];
            history.add_view(&view);
        }
        assert_eq!(history.strokes[0].moments.len(), 10);
        assert!(history.strokes[0].down);
        view.touches.clear();
        view.t_ns += 10 * NANOS_PER_MS;
        history.add_view(&view);
        assert!(!history.strokes[0].down);
        view.t_ns += HISTORY_NS + 1;
        history.add_view(&view);
        assert!(history.strokes.is_empty());
    }

    #[test]
    fn a_restarted_source_clears_the_history() {
        let mut view = still::view();
        let mut history = History::default();
        view.t_ns = 9000 * NANOS_PER_MS;
        view.touches = vec![touch(1, [5.0, 5.0], 0.5)];
        history.add_view(&view);
        view.t_ns = 10 * NANOS_PER_MS;
        view.touches.clear();
        history.add_view(&view);
        assert!(history.strokes.is_empty());
        assert_eq!(history.now_ns, view.t_ns);
    }

    #[test]
    fn a_release_that_no_view_contained_ends_its_press() {
        let mut view = still::view();
        let mut history = History::default();
        view.t_ns = 100 * NANOS_PER_MS;
        view.events = [event(50, true)].into();
        view.events_so_far = 1;
        view.held = vec!["key:f".parse().expect("a key")];
        history.add_view(&view);
        assert_eq!(history.presses[0].until_ns, None);
        view.held.clear();
        view.t_ns = 200 * NANOS_PER_MS;
        history.add_view(&view);
        assert_eq!(history.presses[0].until_ns, Some(view.t_ns));
    }
}
