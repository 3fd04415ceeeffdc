//! Fingers on the simulated pad, placed by mouse, touch screen or keyboard. No drawing.
//!
//! Invariant: a finger stays until it is lifted; a pinned one until it is unpinned or all are lifted.

use crate::eit::Press;
use crate::source::Finger;
use crate::types::PointMm;

/// Initial force, 0 to 1.
pub const DEFAULT_FORCE: f64 = 0.5;
/// Change of the force per notch of the mouse wheel.
const FORCE_STEP: f64 = 0.1;
/// Smallest and largest force.
const FORCE_RANGE: (f64, f64) = (0.1, 1.0);
/// Radius (mm) and relative rise of conductivity at force 0, and the increase up to force 1. Force 0.5 gives the finger of the
/// touch scripts: 7 mm and 1.2.
const RADIUS_MM: (f64, f64) = (5.5, 3.0);
const RISE: (f64, f64) = (0.4, 1.6);
/// A press within this distance of a pinned finger removes it, mm.
const UNPIN_MM: f64 = 7.0;
/// Largest number of fingers on the pad.
const MAX_FINGERS: usize = 5;

/// What holds a finger down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Holder {
    /// The mouse button.
    Mouse,
    /// A finger on a touch screen, by its id.
    Screen(u64),
    /// A digit key.
    Digit(u8),
    /// Nothing: the finger is pinned.
    Pin,
}

#[derive(Clone, Copy, Debug)]
struct Held {
    holder: Holder,
    id: u64,
    place_mm: PointMm,
    force: f64,
}

/// The fingers on the pad.
#[derive(Clone, Debug)]
pub struct Fingers {
    held: Vec<Held>,
    next_id: u64,
    force: f64,
}

impl Default for Fingers {
    fn default() -> Self {
        Self {
            held: Vec::new(),
            next_id: 1,
            force: DEFAULT_FORCE,
        }
    }
}

impl Fingers {
    /// Puts a finger down; the mouse on a pinned finger removes that one instead. Returns whether anything changed.
    pub fn press(&mut self, holder: Holder, place_mm: PointMm) -> bool {
        if holder == Holder::Mouse
            && let Some(pinned) = self.pinned_at(place_mm)
        {
            self.held.remove(pinned);
            return true;
        }
        self.lift(holder);
        self.add(holder, place_mm)
    }

    /// Puts one more finger down; returns whether there was room for it.
    fn add(&mut self, holder: Holder, place_mm: PointMm) -> bool {
        if self.held.len() == MAX_FINGERS {
            return false;
        }
        self.held.push(Held {
            holder,
            id: self.next_id,
            place_mm,
            force: self.force,
        });
        self.next_id += 1;
        true
    }

    /// Moves a finger; returns whether it moved.
    pub fn slide(&mut self, holder: Holder, place_mm: PointMm) -> bool {
        match self.held.iter_mut().find(|held| held.holder == holder) {
            Some(held) if held.place_mm != place_mm => {
                held.place_mm = place_mm;
                true
            }
            _ => false,
        }
    }

    /// Lifts a finger; returns whether it was down.
    pub fn lift(&mut self, holder: Holder) -> bool {
        let before = self.held.len();
        self.held.retain(|held| held.holder != holder);
        self.held.len() < before
    }

    /// Lifts all fingers, pinned ones too; returns whether there were any.
    pub fn lift_all(&mut self) -> bool {
        let any = !self.held.is_empty();
        self.held.clear();
        any
    }

    /// Pins the newest finger of the mouse or of a key where it is; returns whether there was one.
    pub fn pin(&mut self) -> bool {
        let can_pin = |held: &&mut Held| matches!(held.holder, Holder::Mouse | Holder::Digit(_));
        match self.held.iter_mut().rev().find(can_pin) {
            Some(held) => {
                held.holder = Holder::Pin;
                true
            }
            None => false,
        }
    }

    /// Pins a finger at a place, or removes the pinned one there; returns whether anything changed.
    pub fn toggle_pin(&mut self, place_mm: PointMm) -> bool {
        match self.pinned_at(place_mm) {
            Some(pinned) => {
                self.held.remove(pinned);
                true
            }
            None => self.add(Holder::Pin, place_mm),
        }
    }

    /// Changes the force by notches, for the finger of the mouse and for later ones; returns whether it changed.
    pub fn change_force(&mut self, notches: f64) -> bool {
        let force = (self.force + notches * FORCE_STEP).clamp(FORCE_RANGE.0, FORCE_RANGE.1);
        let changed = force != self.force;
        self.force = force;
        for held in &mut self.held {
            if held.holder == Holder::Mouse {
                held.force = force;
            }
        }
        changed
    }

    /// Force of the next finger, 0.1 to 1.
    pub fn force(&self) -> f64 {
        self.force
    }

    /// Whether any finger is down.
    pub fn any_down(&self) -> bool {
        !self.held.is_empty()
    }

    /// Whether the mouse holds a finger down.
    pub fn mouse_is_down(&self) -> bool {
        self.held.iter().any(|held| held.holder == Holder::Mouse)
    }

    /// Positions of the pinned fingers, mm.
    pub fn pinned_mm(&self) -> impl Iterator<Item = PointMm> + '_ {
        self.held
            .iter()
            .filter(|held| held.holder == Holder::Pin)
            .map(|held| held.place_mm)
    }

    /// The fingers for the forward model.
    pub fn for_pad(&self) -> Vec<Finger> {
        self.held
            .iter()
            .map(|held| Finger {
                id: held.id,
                press: Press {
                    centre_mm: held.place_mm,
                    radius_mm: RADIUS_MM.0 + held.force * RADIUS_MM.1,
                    rise: RISE.0 + held.force * RISE.1,
                },
            })
            .collect()
    }

    fn pinned_at(&self, [x, y]: PointMm) -> Option<usize> {
        self.held.iter().position(|held| {
            let [dx, dy] = [held.place_mm[0] - x, held.place_mm[1] - y];
            held.holder == Holder::Pin && dx.hypot(dy) < UNPIN_MM
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_finger_equals_that_of_touch_scripts() {
        let mut fingers = Fingers::default();
        fingers.press(Holder::Mouse, [50.0, 40.0]);
        let [Finger { press, .. }] = fingers.for_pad()[..] else {
            panic!("one finger");
        };
        assert!((press.radius_mm - 7.0).abs() < 1e-9 && (press.rise - 1.2).abs() < 1e-9);
        assert_eq!(press.centre_mm, [50.0, 40.0]);
    }

    #[test]
    fn a_pinned_finger_stays_until_it_is_pressed_again() {
        let mut fingers = Fingers::default();
        fingers.press(Holder::Mouse, [20.0, 20.0]);
        assert!(fingers.pin());
        assert!(!fingers.lift(Holder::Mouse), "it is pinned");
        fingers.press(Holder::Mouse, [80.0, 50.0]);
        assert_eq!(fingers.for_pad().len(), 2);
        fingers.lift(Holder::Mouse);
        assert_eq!(fingers.pinned_mm().collect::<Vec<_>>(), [[20.0, 20.0]]);
        fingers.press(Holder::Mouse, [22.0, 21.0]);
        assert!(!fingers.any_down());
    }

    #[test]
    fn a_finger_of_a_key_is_pinned_too() {
        let mut fingers = Fingers::default();
        fingers.press(Holder::Digit(1), [20.0, 20.0]);
        assert!(fingers.pin() && !fingers.lift(Holder::Digit(1)));
        assert!(!fingers.pin(), "no other finger");
        fingers.press(Holder::Digit(2), [80.0, 50.0]);
        assert_eq!(fingers.for_pad().len(), 2);
        assert!(fingers.lift(Holder::Digit(2)));
        assert_eq!(fingers.pinned_mm().collect::<Vec<_>>(), [[20.0, 20.0]]);
    }

    #[test]
    fn two_pins_and_the_mouse_press_at_once() {
        let mut fingers = Fingers::default();
        assert!(fingers.toggle_pin([20.0, 20.0]));
        assert!(fingers.toggle_pin([60.0, 20.0]));
        fingers.press(Holder::Mouse, [80.0, 50.0]);
        assert_eq!(fingers.for_pad().len(), 3, "walk, run and jump");
        assert!(fingers.toggle_pin([61.0, 20.0]));
        assert_eq!(fingers.pinned_mm().collect::<Vec<_>>(), [[20.0, 20.0]]);
    }

    #[test]
    fn the_wheel_changes_the_force_within_its_range() {
        let mut fingers = Fingers::default();
        fingers.press(Holder::Mouse, [20.0, 20.0]);
        fingers.change_force(2.0);
        assert!((fingers.for_pad()[0].press.rise - 1.52).abs() < 1e-12);
        assert!(fingers.change_force(100.0) && fingers.force() == 1.0);
        assert!(!fingers.change_force(1.0), "the largest force");
        fingers.change_force(-100.0);
        assert_eq!(fingers.force(), 0.1);
    }

    #[test]
    fn a_touch_screen_puts_five_fingers_down_at_most() {
        let mut fingers = Fingers::default();
        for id in 0..9 {
            fingers.press(Holder::Screen(id), [10.0 * id as f64, 30.0]);
        }
        assert_eq!(fingers.for_pad().len(), MAX_FINGERS);
        assert!(fingers.slide(Holder::Screen(3), [33.0, 40.0]));
        assert!(!fingers.slide(Holder::Screen(8), [1.0, 1.0]));
        assert!(fingers.lift_all() && !fingers.lift_all());
    }

    #[test]
    fn every_finger_has_its_own_id() {
        let mut fingers = Fingers::default();
        fingers.press(Holder::Mouse, [20.0, 20.0]);
        let first = fingers.for_pad()[0].id;
        fingers.press(Holder::Mouse, [60.0, 20.0]);
        assert_ne!(fingers.for_pad()[0].id, first);
    }
}
