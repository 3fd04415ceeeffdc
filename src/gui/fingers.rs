//! Fingers that a mouse, a touch screen or the keyboard puts on the simulated pad. Pure: what is pressed goes in, fingers for
//! the forward model come out.
//!
//! Invariant: a finger on the screen is on the pad until it is lifted, pinned ones until they are unpinned or all are lifted.

use crate::source::Finger;
use crate::types::PointMm;

/// How hard a press is before the wheel has turned.
pub const USUAL_FORCE: f64 = 0.5;
/// A notch of the wheel.
const FORCE_STEP: f64 = 0.1;
/// The softest press is still one.
const FORCES: (f64, f64) = (0.1, 1.0);
/// Radius (mm) and relative rise of conductivity of the softest finger, and what the full force adds: 7 mm and 1.2 at half of
/// it, the finger of the scripts.
const RADIUS_MM: (f64, f64) = (5.5, 3.0);
const RISE: (f64, f64) = (0.4, 1.6);
/// A pinned finger is met this near, mm.
const REACH_MM: f64 = 7.0;
/// The pad tells so many fingers apart at most.
const MOST_FINGERS: usize = 5;

/// What holds a finger down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Holder {
    /// The mouse's button.
    Mouse,
    /// A finger on a touch screen, by its number.
    Screen(u64),
    /// A digit of the keyboard.
    Digit(u8),
    /// Nothing: it is pinned.
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
            force: USUAL_FORCE,
        }
    }
}

impl Fingers {
    /// Puts a finger down, or takes a pinned one away that the mouse meets; whether anything changed.
    pub fn press(&mut self, holder: Holder, place_mm: PointMm) -> bool {
        if holder == Holder::Mouse
            && let Some(pinned) = self.pinned_at(place_mm)
        {
            self.held.remove(pinned);
            return true;
        }
        self.lift(holder);
        if self.held.len() == MOST_FINGERS {
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

    /// Moves a finger; whether it is there.
    pub fn slide(&mut self, holder: Holder, place_mm: PointMm) -> bool {
        match self.held.iter_mut().find(|held| held.holder == holder) {
            Some(held) if held.place_mm != place_mm => {
                held.place_mm = place_mm;
                true
            }
            _ => false,
        }
    }

    /// Lifts a finger; whether it was there.
    pub fn lift(&mut self, holder: Holder) -> bool {
        let before = self.held.len();
        self.held.retain(|held| held.holder != holder);
        self.held.len() < before
    }

    /// Lifts all of them, pinned ones too; whether there were any.
    pub fn lift_all(&mut self) -> bool {
        let any = !self.held.is_empty();
        self.held.clear();
        any
    }

    /// Lets the mouse's finger stay where it is when the mouse goes on; whether there was one.
    pub fn pin(&mut self) -> bool {
        match self.held.iter_mut().find(|h| h.holder == Holder::Mouse) {
            Some(held) => {
                held.holder = Holder::Pin;
                true
            }
            None => false,
        }
    }

    /// Presses harder (positive) or softer by notches: the mouse's finger and those that come after it.
    pub fn harder(&mut self, notches: f64) -> bool {
        let force = (self.force + notches * FORCE_STEP).clamp(FORCES.0, FORCES.1);
        let changed = force != self.force;
        self.force = force;
        for held in &mut self.held {
            if held.holder == Holder::Mouse {
                held.force = force;
            }
        }
        changed
    }

    /// How hard the next finger presses, 0.1 to 1.
    #[must_use]
    pub fn force(&self) -> f64 {
        self.force
    }

    /// Whether any finger is down that something holds.
    #[must_use]
    pub fn any(&self) -> bool {
        !self.held.is_empty()
    }

    /// Whether a finger of the mouse is down.
    #[must_use]
    pub fn mouse_is_down(&self) -> bool {
        self.held.iter().any(|held| held.holder == Holder::Mouse)
    }

    /// Places of the pinned fingers, mm.
    pub fn pinned_mm(&self) -> impl Iterator<Item = PointMm> + '_ {
        self.held
            .iter()
            .filter(|held| held.holder == Holder::Pin)
            .map(|held| held.place_mm)
    }

    /// The fingers for the forward model.
    #[must_use]
    pub fn for_pad(&self) -> Vec<Finger> {
        self.held
            .iter()
            .map(|held| Finger {
                id: held.id,
                centre_mm: held.place_mm,
                radius_mm: RADIUS_MM.0 + held.force * RADIUS_MM.1,
                rise: RISE.0 + held.force * RISE.1,
            })
            .collect()
    }

    fn pinned_at(&self, [x, y]: PointMm) -> Option<usize> {
        self.held.iter().position(|held| {
            let [dx, dy] = [held.place_mm[0] - x, held.place_mm[1] - y];
            held.holder == Holder::Pin && dx.hypot(dy) < REACH_MM
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_finger_is_the_one_of_the_scripts() {
        let mut fingers = Fingers::default();
        fingers.press(Holder::Mouse, [50.0, 40.0]);
        let [finger] = fingers.for_pad()[..] else {
            panic!("one finger");
        };
        assert!((finger.radius_mm - 7.0).abs() < 1e-9 && (finger.rise - 1.2).abs() < 1e-9);
        assert_eq!(finger.centre_mm, [50.0, 40.0]);
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
        assert!(!fingers.any());
    }

    #[test]
    fn the_wheel_makes_the_finger_that_is_down_harder_and_stays_in_its_range() {
        let mut fingers = Fingers::default();
        fingers.press(Holder::Mouse, [20.0, 20.0]);
        fingers.harder(2.0);
        assert!((fingers.for_pad()[0].rise - 1.52).abs() < 1e-12);
        assert!(fingers.harder(100.0) && fingers.force() == 1.0);
        assert!(!fingers.harder(1.0), "no harder than that");
        fingers.harder(-100.0);
        assert_eq!(fingers.force(), 0.1);
    }

    #[test]
    fn fingers_of_a_screen_are_as_many_as_the_pad_tells_apart() {
        let mut fingers = Fingers::default();
        for id in 0..9 {
            fingers.press(Holder::Screen(id), [10.0 * id as f64, 30.0]);
        }
        assert_eq!(fingers.for_pad().len(), MOST_FINGERS);
        assert!(fingers.slide(Holder::Screen(3), [33.0, 40.0]));
        assert!(!fingers.slide(Holder::Screen(8), [1.0, 1.0]));
        assert!(fingers.lift_all() && !fingers.lift_all());
    }

    #[test]
    fn every_finger_has_a_number_of_its_own() {
        let mut fingers = Fingers::default();
        fingers.press(Holder::Mouse, [20.0, 20.0]);
        let first = fingers.for_pad()[0].id;
        fingers.press(Holder::Mouse, [60.0, 20.0]);
        assert_ne!(fingers.for_pad()[0].id, first);
    }
}
