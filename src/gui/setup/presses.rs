//! Presses that the set-up asks for, gathered from views. Pure: views in, presses and trials out.
//!
//! A calibration's press counts while exactly one touch is down; its first views are left out, as the finger still sinks in.

use crate::calibrate::recommend::{Asked, Trial};
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

/// Takes what a person does with one thing asked for.
#[derive(Clone, Debug, Default)]
pub struct TrialTaker {
    touches: Vec<(Nanos, Touch)>,
    down: Vec<Touch>,
    last_ns: Nanos,
}

impl TrialTaker {
    /// Takes a view.
    pub fn view(&mut self, view: &View) {
        if view.t_ns == self.last_ns {
            return;
        }
        self.last_ns = view.t_ns;
        for touch in &view.touches {
            let known = self.down.iter().any(|down| down.id == touch.id);
            let phase = if known { Phase::Move } else { Phase::Down };
            self.touches.push((view.t_ns, Touch { phase, ..*touch }));
        }
        for gone in self
            .down
            .iter()
            .filter(|down| view.touches.iter().all(|touch| touch.id != down.id))
        {
            let touch = Touch {
                phase: Phase::Up,
                ..*gone
            };
            self.touches.push((view.t_ns, touch));
        }
        self.down.clone_from(&view.touches);
    }

    /// How long nothing has been touched after something was; none before or while it is.
    #[must_use]
    pub fn quiet_ns(&self) -> Option<Nanos> {
        let (last_ns, _) = self.touches.last()?;
        self.down
            .is_empty()
            .then(|| self.last_ns.saturating_sub(*last_ns))
    }

    /// The trial, over.
    pub fn finish(&mut self, asked: Option<Asked>) -> Trial {
        Trial {
            asked,
            touches: std::mem::take(&mut self.touches),
        }
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
    fn a_trial_holds_down_moves_and_up_of_every_touch() {
        let mut taker = TrialTaker::default();
        let all = in_time(vec![
            views(2, vec![]),
            views(3, vec![touch(7, [10.0, 10.0], 0.5)]),
            views(30, vec![]),
        ]);
        for view in &all {
            taker.view(view);
        }
        assert_eq!(taker.quiet_ns(), Some(290 * NANOS_PER_MS));
        let phases: Vec<Phase> = taker
            .finish(None)
            .touches
            .iter()
            .map(|(_, touch)| touch.phase)
            .collect();
        assert_eq!(phases, [Phase::Down, Phase::Move, Phase::Move, Phase::Up]);
    }
}
