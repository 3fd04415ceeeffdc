//! Presses that the set-up asks for, gathered from views. Pure: views in, presses and changes of touches out.
//!
//! A calibration's press counts while exactly one touch is down; its first views are left out, as the finger still sinks in.

use crate::calibrate::{Modelled, Press};
use crate::runtime::View;
use crate::types::{Nanos, Phase, PointMm, Touch};

/// Views of a press that are left out, and those whose mean is taken.
const SETTLE: usize = 4;
const TAKEN: usize = 15;

/// What a view has brought.
#[derive(Clone, Debug, PartialEq)]
pub enum Taken {
    /// Nothing yet.
    Nothing,
    /// A press that cannot be used, and why.
    Unfit(&'static str),
    /// A press.
    Press(Press),
}

/// Takes the press at a shown place.
#[derive(Clone, Debug, Default)]
pub struct PressTaker {
    seen: usize,
    sums: Vec<f64>,
    place: [f64; 2],
    force: f64,
    count: usize,
    several: bool,
    last_ns: Nanos,
}

impl PressTaker {
    /// Takes a view while this place is shown.
    pub fn view(&mut self, view: &View, shown_mm: PointMm) -> Taken {
        if view.t_ns == self.last_ns {
            return Taken::Nothing;
        }
        self.last_ns = view.t_ns;
        match view.touches.as_slice() {
            [] if self.seen == 0 => Taken::Nothing,
            [] => {
                let done = std::mem::take(self);
                self.last_ns = done.last_ns;
                done.press(shown_mm)
            }
            touches => {
                self.seen += 1;
                self.several |= touches.len() > 1;
                if self.seen > SETTLE && self.count < TAKEN {
                    self.add(view, &touches[0]);
                }
                Taken::Nothing
            }
        }
    }

    fn add(&mut self, view: &View, touch: &Touch) {
        self.sums.resize(view.signals.changes.len(), 0.0);
        for (sum, change) in self.sums.iter_mut().zip(&view.signals.changes) {
            *sum += f64::from(*change);
        }
        for (sum, place) in self.place.iter_mut().zip(touch.contact.centre_mm) {
            *sum += place;
        }
        self.force += touch.contact.force;
        self.count += 1;
    }

    fn press(self, place_mm: PointMm) -> Taken {
        if self.several {
            return Taken::Unfit("several touches at once: press with one finger");
        }
        if self.count == 0 {
            return Taken::Unfit("too short: press a little longer");
        }
        let share = 1.0 / self.count as f64;
        Taken::Press(Press {
            place_mm,
            modelled: Some(Modelled {
                force: self.force * share,
                place_mm: self.place.map(|sum| sum * share),
            }),
            changes: self.sums.iter().map(|sum| sum * share).collect(),
        })
    }
}

/// What becomes of touches from view to view.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    down: Vec<Touch>,
    last_ns: Nanos,
}

impl Changes {
    /// What this view changes; nothing if it has been seen.
    pub fn view(&mut self, view: &View) -> Vec<Touch> {
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
    fn a_press_is_taken_when_it_is_over() {
        let mut taker = PressTaker::default();
        let all = in_time(vec![
            views(5, vec![]),
            views(20, vec![touch(1, [41.0, 52.0], 0.6)]),
            views(1, vec![]),
        ]);
        let taken: Vec<Taken> = all.iter().map(|v| taker.view(v, [40.0, 50.0])).collect();
        assert!(taken[..25].iter().all(|t| *t == Taken::Nothing));
        let Taken::Press(press) = &taken[25] else {
            panic!("{:?}", taken[25]);
        };
        assert_eq!(press.place_mm, [40.0, 50.0]);
        let modelled = press.modelled.expect("modelled");
        assert!((modelled.place_mm[0] - 41.0).abs() < 1e-9);
        assert!((press.changes[1] + 0.25).abs() < 1e-9);
    }

    #[test]
    fn a_brush_and_two_fingers_are_refused() {
        for (fingers, frames, told) in [
            (vec![touch(1, [1.0, 1.0], 0.5)], 3, "too short"),
            (
                vec![touch(1, [1.0, 1.0], 0.5), touch(2, [60.0, 60.0], 0.5)],
                20,
                "several",
            ),
        ] {
            let mut taker = PressTaker::default();
            let all = in_time(vec![views(frames, fingers), views(1, vec![])]);
            let last = all.iter().map(|v| taker.view(v, [1.0, 1.0])).last();
            let Some(Taken::Unfit(why)) = last else {
                panic!("{last:?}");
            };
            assert!(why.starts_with(told));
        }
    }

    #[test]
    fn a_touch_goes_down_moves_and_comes_up() {
        let all = in_time(vec![
            views(2, vec![]),
            views(3, vec![touch(7, [10.0, 10.0], 0.5)]),
            views(30, vec![]),
        ]);
        let mut changes = Changes::default();
        // Every view is seen twice: nothing comes of the second time.
        let changed = all.iter().flat_map(|v| [changes.view(v), changes.view(v)]);
        let phases: Vec<Phase> = changed.flatten().map(|touch| touch.phase).collect();
        assert_eq!(phases, [Phase::Down, Phase::Move, Phase::Move, Phase::Up]);
    }
}
