//! The order of drives in which a press is placed soonest.
//!
//! A press may begin before any drive. It counts as placed when the drives since then tell of a change that noise does not make, and
//! of the place as exactly as a region needs. Orders are improved by exchanging two drives as long as that helps. The mean square of the
//! number of drives is what counts, so that seldom long delays weigh more than a short one.

use rayon::prelude::*;

use super::information::{Knowledge, PressInformation};
use crate::stats::{mean, quantile};

/// A press is placed when its place is known this well, mm: half a region of 20 mm is 4 deviations, ...
const PLACED_MM: f64 = 2.5;
/// ... and the readings differ from the untouched pad by this much, sum of squares in deviations of their noise.
const SEEN_CHI2: f64 = 60.0;

/// An order of drives, and how soon it places a press.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DriveOrder {
    /// The drives' numbers in the pad's protocol.
    pub(super) order: Vec<usize>,
    /// Drives that are read until a press is placed: one for each finger and each drive before which it may begin.
    drives: Vec<f64>,
}

impl DriveOrder {
    /// Mean number of drives.
    pub(super) fn mean(&self) -> f64 {
        mean(self.drives.iter().copied())
    }

    /// Number of drives that suffices for a share of the presses.
    pub(super) fn quantile(&self, share: f64) -> f64 {
        quantile(self.drives.iter().copied(), share).unwrap_or(f64::NAN)
    }

    fn cost(&self) -> f64 {
        mean(self.drives.iter().map(|n| n * n))
    }
}

/// Orders of drives for some fingers.
pub(super) struct OrderSearch {
    prior: Knowledge,
    /// For each finger, what each drive tells.
    told: Vec<Vec<Knowledge>>,
    drives: usize,
}

impl OrderSearch {
    /// `drives` holds the channels of each drive.
    pub(super) fn new(
        fingers: &[PressInformation],
        prior: Knowledge,
        drives: &[Vec<usize>],
    ) -> Self {
        let told = fingers.iter().map(|finger| {
            let of_drive = |drive: &Vec<usize>| finger.of_channels(drive.iter().copied());
            drives.iter().map(of_drive).collect()
        });
        Self {
            prior,
            told: told.collect(),
            drives: drives.len(),
        }
    }

    /// How soon an order places presses.
    pub(super) fn judge(&self, order: Vec<usize>) -> DriveOrder {
        let drives = self.told.iter().flat_map(|told| {
            let order = &order;
            (0..order.len()).map(move |start| self.drives_until_placed(told, order, start))
        });
        DriveOrder {
            drives: drives.collect(),
            order,
        }
    }

    fn drives_until_placed(&self, told: &[Knowledge], order: &[usize], start: usize) -> f64 {
        let mut known = self.prior;
        for count in 1..=order.len() {
            known = known.and(&told[order[(start + count - 1) % order.len()]]);
            if known.chi2 >= SEEN_CHI2 && known.rms_mm() <= PLACED_MM {
                return count as f64;
            }
        }
        // Another round averages the noise; it does not place a press that a whole frame cannot place.
        2.0 * order.len() as f64
    }

    /// The orders that go round the pad by a step.
    pub(super) fn strides(&self) -> Vec<(usize, DriveOrder)> {
        let is_round = |step: &usize| gcd(*step, self.drives) == 1;
        (1..=self.drives / 2)
            .filter(is_round)
            .map(|step| {
                let order = (0..self.drives).map(|k| k * step % self.drives).collect();
                (step, self.judge(order))
            })
            .collect()
    }

    /// The best order that exchanging two drives leads to, from the best of the strides.
    pub(super) fn best(&self) -> DriveOrder {
        let strides = self.strides().into_iter().map(|(_, order)| order);
        let mut best = strides
            .min_by(|a, b| a.cost().total_cmp(&b.cost()))
            .unwrap_or_else(|| self.judge((0..self.drives).collect()));
        // The first drive stays: turning an order changes nothing.
        let pairs: Vec<(usize, usize)> = (1..self.drives)
            .flat_map(|a| (a + 1..self.drives).map(move |b| (a, b)))
            .collect();
        loop {
            let exchanged = |(a, b): &(usize, usize)| {
                let mut order = best.order.clone();
                order.swap(*a, *b);
                self.judge(order)
            };
            let tried: Vec<DriveOrder> = pairs.par_iter().map(exchanged).collect();
            let better = tried
                .into_iter()
                .min_by(|a, b| a.cost().total_cmp(&b.cost()))
                .filter(|order| order.cost() < best.cost());
            match better {
                Some(order) => best = order,
                None => return best,
            }
        }
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}
