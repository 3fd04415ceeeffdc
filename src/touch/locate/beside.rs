//! A finger that lands beside one that is held, on a pad that was learned from presses.
//!
//! Learned maps leave so much unexplained that one harder touch between two fingers explains both nearly as well, and the fit, which
//! starts from the touch of the frame before, finds it first. But a held finger does not leap in one frame and double its force: a touch
//! that stayed and a new one beside it are likelier, though they explain little more.

use super::locator::{DOWN_GAIN, Locator, volume_mm2};
use super::new_touches::{NEW_TOUCH_STEPS, edited, least_apart_mm};
use crate::eit::response::TouchModel;
use crate::types::{PointMm, distance_mm};

/// A touch has leapt if it is farther than this from its place in the last frame, mm: no finger slides at 600 mm/s.
const LEAP_MM: f64 = 6.0;
/// Of two explanations the touch that stayed may be worse by this many times [`DOWN_GAIN`].
const LEAP_GAINS: f64 = 2.0;
/// Each of the two is at least this hard, rise x area, mm2: a third of a typical press.
const LEAST_VOLUME_MM2: f64 = 25.0;
/// Two fingers are at least this far apart, mm.
const APART_MM: f64 = 15.0;

impl Locator {
    /// If a touch leapt since the last frame, tries whether it stayed and another finger landed.
    pub(super) fn try_landing_beside(&mut self, noise: f64) {
        let is_as_many = self.fit.touches.len() == self.before.len();
        if !self.model.is_learned() || !is_as_many || !self.has_leapt() {
            return;
        }
        let before = self.before.clone();
        self.try_fit(&before, 0);
        let Some(peak) = self.peak(&self.trial.residual) else {
            return;
        };
        let another = edited(&before, &[self.bounds.typical(peak.place_mm)], None);
        self.try_fit(&another, NEW_TOUCH_STEPS);
        let places = before.iter().map(|touch| touch.centre_mm);
        let stayed = all_met(places, &self.trial.touches);
        let are_pressed = self
            .trial
            .touches
            .iter()
            .all(|touch| volume_mm2(touch) > LEAST_VOLUME_MM2);
        if stayed
            && are_pressed
            && self.trial.cost < self.fit.cost + LEAP_GAINS * DOWN_GAIN * noise
            && least_apart_mm(&self.trial.touches) >= APART_MM
        {
            std::mem::swap(&mut self.fit, &mut self.trial);
        }
    }

    /// Whether a touch of the last frame is not where it was.
    fn has_leapt(&self) -> bool {
        let places = self.before.iter().map(|touch| touch.centre_mm);
        !all_met(places, &self.fit.touches)
    }
}

/// Whether there is a touch near each place.
fn all_met(mut places: impl Iterator<Item = PointMm>, touches: &[TouchModel]) -> bool {
    places.all(|place_mm| {
        let mut touches = touches.iter();
        touches.any(|touch| distance_mm(touch.centre_mm, place_mm) <= LEAP_MM)
    })
}
