//! The region that holds a press with a stated probability: a circle around its predicted place.
//!
//! Where the members of a blend disagree, the press is unlike those that were learned from, and its error is larger. The radius
//! grows with the disagreement; its factor is the quantile that presses left out in the cross-validation needed (split
//! conformal prediction: Papadopoulos et al. 2002).

use super::error::CalibrateError;
use crate::stats::quantile;
use crate::types::PointMm;

/// Share of presses within their region.
pub(super) const REGION_SHARE: f64 = 0.9;

/// Radii from the disagreement of members.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Region {
    /// The error of a press on which all members agree, mm.
    floor_mm: f64,
    /// Radius over the root of the sum of squares of floor and disagreement.
    factor: f64,
}

impl Region {
    /// Learns from presses left out: `predicted` has one list of places for each member.
    ///
    /// # Errors
    /// No press was left out.
    pub(super) fn fit(
        predicted: &[Vec<PointMm>],
        shares: &[f64],
        blended: &[PointMm],
        truth: &[PointMm],
    ) -> Result<Self, CalibrateError> {
        let errors: Vec<f64> = blended
            .iter()
            .zip(truth)
            .map(|(a, b)| libm::hypot(a[0] - b[0], a[1] - b[1]))
            .collect();
        let floor_mm = quantile(errors.iter().copied(), 0.5).ok_or(CalibrateError::Alike)?;
        let unit = Self {
            floor_mm: floor_mm.max(f64::MIN_POSITIVE),
            factor: 1.0,
        };
        let radii = unit.radii_mm(predicted, shares, blended);
        let needed = errors
            .iter()
            .zip(&radii)
            .map(|(error, radius)| error / radius);
        // One more press than were seen: the quantile of few presses is too low.
        let count = errors.len() as f64;
        let share = (REGION_SHARE * (count + 1.0) / count).min(1.0);
        let factor = quantile(needed, share).ok_or(CalibrateError::Alike)?;
        Ok(Self { factor, ..unit })
    }

    /// The radius of each press's region, mm.
    pub(super) fn radii_mm(
        &self,
        predicted: &[Vec<PointMm>],
        shares: &[f64],
        blended: &[PointMm],
    ) -> Vec<f64> {
        (0..blended.len())
            .map(|press| {
                let [x, y] = blended[press];
                let disagreement: f64 = predicted
                    .iter()
                    .zip(shares)
                    .map(|(places, share)| {
                        let [px, py] = places[press];
                        share * ((px - x) * (px - x) + (py - y) * (py - y))
                    })
                    .sum();
                self.factor * libm::sqrt(self.floor_mm * self.floor_mm + disagreement)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two members that disagree by as much as they err.
    fn sample(count: usize, from: usize) -> (Vec<Vec<PointMm>>, Vec<PointMm>) {
        let mut members = vec![Vec::new(), Vec::new()];
        let mut truth = Vec::new();
        for i in from..from + count {
            let share = |root: f64| (0.5 + i as f64 * root).fract();
            let error = 0.5 + 10.0 * share(0.754_877_666);
            let turn = std::f64::consts::TAU * share(0.569_840_29);
            truth.push([0.0, 0.0]);
            let place = [error * libm::cos(turn), error * libm::sin(turn)];
            members[0].push([place[0] + 0.7 * error, place[1]]);
            members[1].push([place[0] - 0.7 * error, place[1]]);
        }
        (members, truth)
    }

    #[test]
    fn nine_of_ten_unseen_presses_are_within_their_region() {
        let shares = [0.5, 0.5];
        let blended = super::super::blend::blended;
        let (members, truth) = sample(60, 0);
        let region =
            Region::fit(&members, &shares, &blended(&members, &shares), &truth).expect("presses");
        let (members, truth) = sample(1000, 60);
        let places = blended(&members, &shares);
        let radii = region.radii_mm(&members, &shares, &places);
        let within = places
            .iter()
            .zip(&truth)
            .zip(&radii)
            .filter(|((a, b), radius)| libm::hypot(a[0] - b[0], a[1] - b[1]) <= **radius)
            .count();
        assert!((850..=960).contains(&within), "{within} of 1000");
        assert!(radii[0] != radii[1], "each press has its own region");
    }
}
