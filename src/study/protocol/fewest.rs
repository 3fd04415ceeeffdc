//! The fewest readings that keep an accuracy: readings, or whole drives, are left out one after another, each time the one that
//! is missed least.
//!
//! Leaving out greedily is not proven to be best; what remains is checked by its bound, which holds for any method.

use rayon::prelude::*;

use super::information::{Knowledge, PressInformation};
use crate::stats::mean;

/// What remains after some groups of readings are left out.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Remainder {
    /// Indices of the groups that remain, ascending.
    pub(super) groups: Vec<usize>,
    /// Readings of these groups.
    pub(super) readings: usize,
    /// Least error of place of each finger, mean, mm.
    pub(super) bounds_mm: Vec<f64>,
}

impl Remainder {
    /// Mean over the fingers, mm.
    pub(super) fn mean_mm(&self) -> f64 {
        mean(self.bounds_mm.iter().copied())
    }
}

/// Leaves out groups of readings until a place is not determined any more, and returns what remains each time, all groups first.
pub(super) fn leave_out(
    fingers: &[PressInformation],
    prior: &Knowledge,
    groups: &[Vec<usize>],
) -> Vec<Remainder> {
    let told: Vec<Vec<Knowledge>> = fingers
        .iter()
        .map(|finger| {
            let of_group = |group: &Vec<usize>| finger.of_channels(group.iter().copied());
            groups.iter().map(of_group).collect()
        })
        .collect();
    let mut left: Vec<usize> = (0..groups.len()).collect();
    let mut remainders = Vec::new();
    loop {
        // Summed anew each time: what subtracting leaves would lose digits.
        let known: Vec<Knowledge> = told
            .iter()
            .map(|told| {
                left.iter()
                    .fold(*prior, |sum, group| sum.and(&told[*group]))
            })
            .collect();
        remainders.push(Remainder {
            readings: left.iter().map(|group| groups[*group].len()).sum(),
            bounds_mm: known.iter().map(Knowledge::mean_mm).collect(),
            groups: left.clone(),
        });
        let missed = |group: &usize| -> f64 {
            let without = known
                .iter()
                .zip(&told)
                .map(|(k, told)| k.without(&told[*group]));
            without.map(|knowledge| knowledge.rms_mm()).sum()
        };
        let misses: Vec<f64> = left.par_iter().map(missed).collect();
        let least = (0..left.len()).min_by(|a, b| misses[*a].total_cmp(&misses[*b]));
        match least {
            Some(place) if left.len() > 1 && misses[place].is_finite() => left.remove(place),
            _ => return remainders,
        };
    }
}

/// The fewest readings whose mean bound is at most `keep_mm`; `None` if all readings together miss it.
pub(super) fn fewest(remainders: &[Remainder], keep_mm: f64) -> Option<&Remainder> {
    remainders
        .iter()
        .take_while(|remainder| remainder.mean_mm() <= keep_mm)
        .last()
}
