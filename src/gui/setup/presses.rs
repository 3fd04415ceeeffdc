//! Presses and touches gathered from the views of a running game. Pure.

use crate::calibrate::{PressRecorder, RecordedPress, Touching, UntouchedLevel};
use crate::runtime::View;
use crate::types::{Nanos, Phase, PointMm, Touch};

/// Records presses at shown places from views.
#[derive(Clone, Debug, Default)]
pub struct ViewPresses {
    recorder: PressRecorder,
    level: UntouchedLevel,
    last_ns: Nanos,
}

impl ViewPresses {
    /// Takes a view while `shown_mm` is shown; a view that was taken before is ignored.
    pub fn take_view(&mut self, view: &View, shown_mm: PointMm) -> RecordedPress {
        if view.t_ns == self.last_ns {
            return RecordedPress::Pending;
        }
        self.last_ns = view.t_ns;
        let touching = Touching::from_contacts(view.touches.len(), &view.signals.contacts);
        let signals = &view.signals;
        let is_touched = !view.touches.is_empty();
        let volts = (!signals.is_turned).then_some(signals.volts.as_slice());
        let changes = self.level.take_frame(is_touched, volts, &signals.changes);
        self.recorder.take_frame(touching, changes, shown_mm)
    }

    /// Whether nothing touches the pad in the view last taken, and no finger has just left it.
    pub fn is_untouched(&self) -> bool {
        self.level.is_untouched()
    }
}

/// Turns views, which hold the touches that are down, into touches that go down, move and go up.
#[derive(Clone, Debug, Default)]
pub struct TouchChanges {
    down: Vec<Touch>,
    last_ns: Nanos,
}

impl TouchChanges {
    /// The touches that this view changes; none if the view was taken before.
    pub fn take_view(&mut self, view: &View) -> Vec<Touch> {
        if view.t_ns == self.last_ns {
            return Vec::new();
        }
        self.last_ns = view.t_ns;
        let is_in = |touches: &[Touch], touch: &Touch| touches.iter().any(|t| t.id == touch.id);
        let there = view.touches.iter().map(|touch| {
            let phase = match is_in(&self.down, touch) {
                true => Phase::Move,
                false => Phase::Down,
            };
            Touch { phase, ..*touch }
        });
        let gone = self.down.iter().filter(|down| !is_in(&view.touches, down));
        let gone = gone.map(|touch| Touch {
            phase: Phase::Up,
            ..*touch
        });
        let changed = there.chain(gone).collect();
        self.down.clone_from(&view.touches);
        changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::Press;
    use crate::gui::still::{self, touch};
    use crate::types::NANOS_PER_MS;

    fn views(frames: usize, touches: Vec<Touch>) -> Vec<View> {
        (0..frames)
            .map(|_| {
                let mut view = still::view();
                view.touches = touches.clone();
                view.signals.changes = vec![0.5, -0.25];
                view
            })
            .collect()
    }

    fn in_time(parts: Vec<Vec<View>>) -> Vec<View> {
        let mut views: Vec<View> = parts.into_iter().flatten().collect();
        for (index, view) in views.iter_mut().enumerate() {
            view.t_ns = (index as u64 + 1) * 10 * NANOS_PER_MS;
        }
        views
    }

    #[test]
    fn a_calibration_learns_from_uncorrected_contacts_and_takes_each_view_once() {
        let mut pressed = views(20, vec![touch(1, [60.0, 70.0], 0.6)]);
        for view in &mut pressed {
            view.signals.contacts = vec![touch(1, [41.0, 52.0], 0.6).contact];
        }
        let all = in_time(vec![views(5, vec![]), pressed, views(2, vec![])]);
        let mut presses = ViewPresses::default();
        let recorded: Vec<Press> = all
            .iter()
            .flat_map(|view| [view, view])
            .filter_map(|view| match presses.take_view(view, [40.0, 50.0]) {
                RecordedPress::Complete(press) => Some(press),
                _ => None,
            })
            .collect();
        let [press] = &recorded[..] else {
            panic!("{recorded:?}");
        };
        let modelled = press.modelled.expect("located");
        assert!((modelled.place_mm[0] - 41.0).abs() < 1e-9, "{modelled:?}");
        assert!((press.changes[1] + 0.25).abs() < 1e-9);
    }

    #[test]
    fn a_touch_goes_down_moves_and_comes_up() {
        let all = in_time(vec![
            views(2, vec![]),
            views(3, vec![touch(7, [10.0, 10.0], 0.5)]),
            views(30, vec![]),
        ]);
        let mut changes = TouchChanges::default();
        // Each view is taken twice; the second time changes nothing.
        let changed = all
            .iter()
            .flat_map(|v| [changes.take_view(v), changes.take_view(v)]);
        let phases: Vec<Phase> = changed.flatten().map(|touch| touch.phase).collect();
        assert_eq!(phases, [Phase::Down, Phase::Move, Phase::Move, Phase::Up]);
    }
}
