//! Compares contacts with the true touches.
//!
//! Each touch is paired with at most one contact within a reach: as many pairs as possible, and of these the pairs with the
//! least sum of distances. Touches left over are missed, contacts left over are false; neither enters an error of place.

use crate::study::Press;
use crate::types::{Contact, PointMm, distance_mm};

/// Largest distance of a contact from its touch, mm (scaled with the pad).
pub(super) const REACH_MM: f64 = 10.0;

/// A touch that was detected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    /// Distance of the contact from the truth, mm.
    pub off_mm: f64,
    /// Detected force, 0 to 1.
    pub force: f64,
}

/// The contacts of one frame compared with its touches.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Score {
    /// For each touch, its contact if it has one.
    pub found: Vec<Option<Found>>,
    /// Contacts without a touch.
    pub false_touches: usize,
}

impl Score {
    pub(super) fn new(presses: &[Press], contacts: &[Contact], reach_mm: f64) -> Self {
        let truths: Vec<PointMm> = presses.iter().map(|press| press.centre_mm).collect();
        let seen: Vec<PointMm> = contacts.iter().map(|contact| contact.centre_mm).collect();
        let assigned = assign(&truths, &seen, reach_mm);
        let found: Vec<Option<Found>> = truths
            .iter()
            .zip(&assigned)
            .map(|(truth, index)| {
                index.map(|index| Found {
                    off_mm: distance_mm(*truth, seen[index]),
                    force: contacts[index].force,
                })
            })
            .collect();
        let paired = found.iter().flatten().count();
        Self {
            found,
            false_touches: contacts.len() - paired,
        }
    }

    /// Number of touches that were not detected.
    pub(super) fn missed(&self) -> usize {
        self.found.iter().filter(|found| found.is_none()).count()
    }

    /// Whether there were as many contacts as touches.
    pub(super) fn is_counted_right(&self) -> bool {
        self.missed() == self.false_touches
    }

    /// Whether every touch was detected and nothing else.
    pub(super) fn is_right(&self) -> bool {
        self.missed() == 0 && self.false_touches == 0
    }
}

/// For each true place the index of its contact, if it has one within reach.
pub(super) fn assign(truths: &[PointMm], seen: &[PointMm], reach_mm: f64) -> Vec<Option<usize>> {
    let mut search = Search {
        truths,
        seen,
        reach_mm,
        chosen: Vec::new(),
        best: (0, 0.0, vec![None; truths.len()]),
    };
    search.descend(0, 0.0);
    search.best.2
}

/// An exhaustive search over all assignments: there are at most three touches.
struct Search<'a> {
    truths: &'a [PointMm],
    seen: &'a [PointMm],
    reach_mm: f64,
    chosen: Vec<Option<usize>>,
    /// Number of pairs, sum of their distances, and the assignment.
    best: (usize, f64, Vec<Option<usize>>),
}

impl Search<'_> {
    fn descend(&mut self, pairs: usize, sum_mm: f64) {
        let Some(truth) = self.truths.get(self.chosen.len()) else {
            if pairs > self.best.0 || (pairs == self.best.0 && sum_mm < self.best.1) {
                self.best = (pairs, sum_mm, self.chosen.clone());
            }
            return;
        };
        for index in 0..self.seen.len() {
            let off_mm = distance_mm(*truth, self.seen[index]);
            if off_mm <= self.reach_mm && !self.chosen.contains(&Some(index)) {
                self.chosen.push(Some(index));
                self.descend(pairs + 1, sum_mm + off_mm);
                self.chosen.pop();
            }
        }
        self.chosen.push(None);
        self.descend(pairs, sum_mm);
        self.chosen.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn press(x: f64, y: f64) -> Press {
        Press {
            centre_mm: [x, y],
            radius_mm: 7.0,
            rise: 1.0,
        }
    }

    fn contact(x: f64, y: f64) -> Contact {
        Contact {
            centre_mm: [x, y],
            area_mm2: 100.0,
            force: 0.5,
            confidence: 1.0,
        }
    }

    #[test]
    fn the_assignment_is_best_as_a_whole() {
        // The second contact is the nearest for both touches; taken by the first, it would leave the second without one.
        let truths = [[0.0, 0.0], [8.0, 0.0]];
        let seen = [[-9.0, 0.0], [3.0, 0.0]];
        assert_eq!(assign(&truths, &seen, 10.0), [Some(0), Some(1)]);
        // Crossed pairs would be longer.
        let seen = [[8.0, 1.0], [0.0, 1.0]];
        assert_eq!(assign(&truths, &seen, 10.0), [Some(1), Some(0)]);
    }

    #[test]
    fn a_contact_out_of_reach_makes_a_missed_and_a_false_touch() {
        let score = Score::new(
            &[press(20.0, 20.0), press(60.0, 60.0)],
            &[contact(23.0, 24.0), contact(60.0, 71.0)],
            10.0,
        );
        assert_eq!((score.missed(), score.false_touches), (1, 1));
        assert!(score.is_counted_right() && !score.is_right());
        assert_eq!(score.found[0].map(|found| found.off_mm), Some(5.0));
        assert_eq!(score.found[1], None);
    }

    #[test]
    fn an_untouched_pad_has_only_false_touches() {
        let score = Score::new(&[], &[contact(1.0, 1.0)], 10.0);
        assert_eq!((score.missed(), score.false_touches), (0, 1));
        assert!(!score.is_counted_right());
        assert!(Score::new(&[], &[], 10.0).is_right());
    }
}
