//! Shares of a blend: not negative, one in sum, and with the least squared error of place.

use crate::types::PointMm;

/// Sweeps of the exchange between pairs; the last ones move shares by less than a thousandth.
const SWEEPS: usize = 200;
/// A smaller share is dropped: it costs a fit and changes nothing.
const LEAST_SHARE: f64 = 0.01;

/// The shares of members whose guesses (a list a member) are blended to meet the truth.
pub(super) fn shares(guesses: &[Vec<PointMm>], truth: &[PointMm]) -> Vec<f64> {
    let members = guesses.len();
    // Products of the members' errors: with shares w of sum 1 the blend's squared error is w' G w.
    let product = |a: usize, b: usize| -> f64 {
        guesses[a]
            .iter()
            .zip(&guesses[b])
            .zip(truth)
            .map(|((a, b), t)| (a[0] - t[0]) * (b[0] - t[0]) + (a[1] - t[1]) * (b[1] - t[1]))
            .sum()
    };
    let gram: Vec<Vec<f64>> = (0..members)
        .map(|a| (0..members).map(|b| product(a, b)).collect())
        .collect();
    let mut shares = vec![1.0 / members as f64; members];
    for _ in 0..SWEEPS {
        for a in 0..members {
            for b in 0..a {
                exchange(&gram, &mut shares, a, b);
            }
        }
    }
    for share in &mut shares {
        if *share < LEAST_SHARE {
            *share = 0.0;
        }
    }
    let sum: f64 = shares.iter().sum();
    shares.iter().map(|share| share / sum).collect()
}

/// Moves share between two members to where the error is least.
fn exchange(gram: &[Vec<f64>], shares: &mut [f64], a: usize, b: usize) {
    let curvature = gram[a][a] - 2.0 * gram[a][b] + gram[b][b];
    if curvature <= 0.0 {
        return;
    }
    let slope: f64 = shares
        .iter()
        .enumerate()
        .map(|(k, share)| share * (gram[k][a] - gram[k][b]))
        .sum();
    let moved = (-slope / curvature).clamp(-shares[a], shares[b]);
    shares[a] += moved;
    shares[b] -= moved;
}

/// The blend of the members' guesses.
pub(super) fn blended(guesses: &[Vec<PointMm>], shares: &[f64]) -> Vec<PointMm> {
    (0..guesses.first().map_or(0, Vec::len))
        .map(|press| {
            let mut place = [0.0; 2];
            for (guesses, share) in guesses.iter().zip(shares) {
                place[0] += share * guesses[press][0];
                place[1] += share * guesses[press][1];
            }
            place
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn no_other_shares_are_better(
            errors in proptest::collection::vec(-1.0..1.0f64, 60),
            other in proptest::collection::vec(0.01..1.0f64, 3),
        ) {
            let truth: Vec<PointMm> = (0..10).map(|i| [i as f64, 1.0]).collect();
            let guesses: Vec<Vec<PointMm>> = (0..3)
                .map(|m| (0..10).map(|i| {
                    let at = 20 * m + 2 * i;
                    [truth[i][0] + errors[at], truth[i][1] + errors[at + 1]]
                }).collect())
                .collect();
            let cost = |shares: &[f64]| -> f64 {
                blended(&guesses, shares).iter().zip(&truth)
                    .map(|(a, t)| (a[0] - t[0]).powi(2) + (a[1] - t[1]).powi(2)).sum()
            };
            let best = shares(&guesses, &truth);
            prop_assert!((best.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            prop_assert!(best.iter().all(|share| *share >= 0.0));
            let sum: f64 = other.iter().sum();
            let other: Vec<f64> = other.iter().map(|share| share / sum).collect();
            // Dropping a share below a hundredth may cost a little.
            prop_assert!(cost(&best) <= cost(&other) * 1.01);
        }
    }
}
