//! Contacts held against the truth: which is which, and what is missed or false.
//!
//! Each touch gets at most one contact and each contact at most one touch, within a reach: as many pairs as can be, and of
//! those with the least sum of distances. What is left over is missed or false and never enters an error of place.

use crate::study::Press;
use crate::types::{Contact, PointMm};

/// A contact further from every touch than this is false, mm (scaled with the pad).
pub(super) const REACH_MM: f64 = 10.0;

/// A touch that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Found {
    /// How far off it was seen, mm.
    pub off_mm: f64,
    /// The force that was read, 0 to 1.
    pub force: f64,
}

/// What one frame made of its touches.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Score {
    /// For each touch, what was found of it.
    pub found: Vec<Option<Found>>,
    /// Contacts that are no touch.
    pub false_touches: usize,
}

impl Score {
    pub(super) fn of(presses: &[Press], contacts: &[Contact], reach_mm: f64) -> Self {
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

    /// Touches that were not found.
    pub(super) fn missed(&self) -> usize {
        self.found.iter().filter(|found| found.is_none()).count()
    }

    /// Whether as many contacts were seen as there were touches.
    pub(super) fn is_counted_right(&self) -> bool {
        self.missed() == self.false_touches
    }

    /// Whether every touch was found and nothing else was seen.
    pub(super) fn is_right(&self) -> bool {
        self.missed() == 0 && self.false_touches == 0
    }
}

/// For each truth the index of its contact, if it has one within reach.
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

/// Tries every assignment: there are at most three touches.
struct Search<'a> {
    truths: &'a [PointMm],
    seen: &'a [PointMm],
    reach_mm: f64,
    chosen: Vec<Option<usize>>,
    /// Pairs, sum of their distances, and the assignment.
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

fn distance_mm(a: PointMm, b: PointMm) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
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
    fn the_whole_is_assigned_best_and_not_each_touch_for_itself() {
        // The second contact is the nearest of both touches; giving it to the first would cost the second its pair.
        let truths = [[0.0, 0.0], [8.0, 0.0]];
        let seen = [[-9.0, 0.0], [3.0, 0.0]];
        assert_eq!(assign(&truths, &seen, 10.0), [Some(0), Some(1)]);
        // Crossed pairs would be longer.
        let seen = [[8.0, 1.0], [0.0, 1.0]];
        assert_eq!(assign(&truths, &seen, 10.0), [Some(1), Some(0)]);
    }

    #[test]
    fn what_is_out_of_reach_is_both_missed_and_false() {
        let score = Score::of(
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
        let score = Score::of(&[], &[contact(1.0, 1.0)], 10.0);
        assert_eq!((score.missed(), score.false_touches), (0, 1));
        assert!(!score.is_counted_right());
        assert!(Score::of(&[], &[], 10.0).is_right());
    }
}
