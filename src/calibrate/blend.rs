//! Shares of a blend of regressions: not negative, with sum 1, and the least squared error of place.

use crate::types::PointMm;

/// Sweeps of exchanges between pairs; the last ones change shares by less than 0.001.
const SWEEPS: usize = 200;
/// Smaller shares are dropped: they cost a fit and hardly change the blend.
const LEAST_SHARE: f64 = 0.01;

/// With this many presses the shares are pulled together as strongly as the members' errors tell them apart.
const FEW_PRESSES: f64 = 25.0;

/// The best shares of members; `predicted` has one list of places for each member.
pub(super) fn shares(predicted: &[Vec<PointMm>], truth: &[PointMm]) -> Vec<f64> {
    let members = predicted.len();
    // With shares w of sum 1 the squared error of the blend is w' G w, G being the products of the members' errors.
    let product = |a: usize, b: usize| -> f64 {
        predicted[a]
            .iter()
            .zip(&predicted[b])
            .zip(truth)
            .map(|((a, b), t)| (a[0] - t[0]) * (b[0] - t[0]) + (a[1] - t[1]) * (b[1] - t[1]))
            .sum()
    };
    let gram: Vec<Vec<f64>> = (0..members)
        .map(|a| (0..members).map(|b| product(a, b)).collect())
        .collect();
    let gram = ridged(gram, truth.len());
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

/// Adds to the diagonal what pulls the shares together: those fitted to few presses are mostly chance.
fn ridged(mut gram: Vec<Vec<f64>>, presses: usize) -> Vec<Vec<f64>> {
    let members = gram.len();
    let mean = (0..members).map(|k| gram[k][k]).sum::<f64>() / members as f64;
    let few = FEW_PRESSES / presses as f64;
    for (k, row) in gram.iter_mut().enumerate() {
        row[k] += few * few * mean;
    }
    gram
}

/// Moves share between two members so that the error is least.
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

/// The blended places.
pub(super) fn blended(predicted: &[Vec<PointMm>], shares: &[f64]) -> Vec<PointMm> {
    (0..predicted.first().map_or(0, Vec::len))
        .map(|press| {
            let mut place = [0.0; 2];
            for (places, share) in predicted.iter().zip(shares) {
                place[0] += share * places[press][0];
                place[1] += share * places[press][1];
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
            let truth: Vec<PointMm> = (0..1000).map(|i| [i as f64, 1.0]).collect();
            let guesses: Vec<Vec<PointMm>> = (0..3)
                .map(|m| (0..1000).map(|i| {
                    let at = 20 * m + 2 * (i % 10);
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
            // Dropping shares below 0.01, and pulling them together, may cost a little.
            prop_assert!(cost(&best) <= cost(&other) * 1.01);
        }
    }
}
