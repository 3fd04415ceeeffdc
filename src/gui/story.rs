//! The last seconds of play, gathered from views: strokes of touches, presses of outputs. Views may skip frames; what they
//! skip is drawn as a straight line.

use std::collections::VecDeque;

use crate::runtime::View;
use crate::types::{Action, NANOS_PER_MS, Nanos, Output, PointMm};

/// How far back it goes.
pub const STORY_NS: Nanos = 5_000 * NANOS_PER_MS;
/// A stroke remembers so many places: five seconds at 100 frames/s, and some.
const MOST_PLACES: usize = 640;
/// Presses that are remembered beyond their five seconds, for who compares lengths.
const MOST_PRESSES: usize = 64;

/// One moment of a touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// When.
    pub t_ns: Nanos,
    /// Where, as the instrument counts, mm.
    pub place_mm: PointMm,
    /// How hard, 0 to 1.
    pub force: f32,
}

/// A touch from its beginning to now, or to its end.
#[derive(Clone, Debug)]
pub struct Stroke {
    /// The touch's number.
    pub id: u64,
    /// When it went down.
    pub since_ns: Nanos,
    /// Whether it is still there.
    pub down: bool,
    /// Its moments, oldest first.
    pub moments: VecDeque<Moment>,
}

/// An output that was down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Press {
    /// Which.
    pub output: Output,
    /// From when.
    pub from_ns: Nanos,
    /// Until when; none while it is down.
    pub until_ns: Option<Nanos>,
}

impl Press {
    /// How long it has been down, or was.
    #[must_use]
    pub fn length_ns(&self, now_ns: Nanos) -> Nanos {
        self.until_ns.unwrap_or(now_ns).saturating_sub(self.from_ns)
    }
}

/// What happened.
#[derive(Clone, Debug, Default)]
pub struct Story {
    /// The newest time.
    pub now_ns: Nanos,
    /// Touches, oldest first.
    pub strokes: VecDeque<Stroke>,
    /// Presses, oldest first.
    pub presses: VecDeque<Press>,
    /// Values of axes, newest last.
    pub axes: Vec<(crate::types::Axis, f32)>,
    events_seen: u64,
}

impl Story {
    /// Takes what is new in a view.
    pub fn take(&mut self, view: &View) {
        if view.t_ns < self.now_ns || view.events_so_far < self.events_seen {
            // Another source, or the same from the start.
            *self = Self::default();
        }
        self.now_ns = view.t_ns;
        self.take_touches(view);
        self.take_events(view);
        self.forget();
    }

    /// The last press that is over, or lasts.
    #[must_use]
    pub fn last_press(&self) -> Option<&Press> {
        self.presses.back()
    }

    fn take_touches(&mut self, view: &View) {
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
            if stroke.moments.len() > MOST_PLACES {
                stroke.moments.pop_front();
            }
        }
    }

    fn take_events(&mut self, view: &View) {
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
        // A release that was skipped, where more events came than a view keeps.
        for press in &mut self.presses {
            if press.until_ns.is_none() && !view.held.contains(&press.output) {
                press.until_ns = Some(view.t_ns);
            }
        }
    }

    fn forget(&mut self) {
        let oldest_ns = self.now_ns.saturating_sub(STORY_NS);
        self.strokes
            .retain(|s| s.down || s.moments.back().is_some_and(|m| m.t_ns >= oldest_ns));
        while self.presses.len() > MOST_PRESSES {
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
    fn a_press_is_as_long_as_its_events_tell_however_few_views_are_seen() {
        let mut view = still::view();
        let mut story = Story::default();
        view.t_ns = 1000 * NANOS_PER_MS;
        view.events = [event(900, true), event(980, false)].into();
        view.events_so_far = 2;
        story.take(&view);
        story.take(&view);
        let lengths: Vec<Nanos> = story.presses.iter().map(|p| p.length_ns(0)).collect();
        assert_eq!(lengths, [80 * NANOS_PER_MS]);
    }

    #[test]
    fn a_touch_leaves_its_way_and_is_forgotten_after_five_seconds() {
        let mut view = still::view();
        let mut story = Story::default();
        for ms in 0..10 {
            view.t_ns = ms * 10 * NANOS_PER_MS;
            view.touches = vec![touch(4, [ms as f64, 50.0], 0.5)];
            story.take(&view);
        }
        assert_eq!(story.strokes[0].moments.len(), 10);
        assert!(story.strokes[0].down);
        view.touches.clear();
        view.t_ns += 10 * NANOS_PER_MS;
        story.take(&view);
        assert!(!story.strokes[0].down);
        view.t_ns += STORY_NS + 1;
        story.take(&view);
        assert!(story.strokes.is_empty());
    }

    #[test]
    fn a_source_that_begins_anew_begins_a_new_story() {
        let mut view = still::view();
        let mut story = Story::default();
        view.t_ns = 9000 * NANOS_PER_MS;
        view.touches = vec![touch(1, [5.0, 5.0], 0.5)];
        story.take(&view);
        view.t_ns = 10 * NANOS_PER_MS;
        view.touches.clear();
        story.take(&view);
        assert!(story.strokes.is_empty());
        assert_eq!(story.now_ns, view.t_ns);
    }

    #[test]
    fn a_release_that_no_view_showed_ends_its_press() {
        let mut view = still::view();
        let mut story = Story::default();
        view.t_ns = 100 * NANOS_PER_MS;
        view.events = [event(50, true)].into();
        view.events_so_far = 1;
        view.held = vec!["key:f".parse().expect("a key")];
        story.take(&view);
        assert_eq!(story.presses[0].until_ns, None);
        view.held.clear();
        view.t_ns = 200 * NANOS_PER_MS;
        story.take(&view);
        assert_eq!(story.presses[0].until_ns, Some(view.t_ns));
    }
}
