//! Summaries of draws: spreads with their count, shares with their interval.

use serde::Serialize;

use crate::stats::{mean, rms};

/// Standard deviations of a 95 % interval.
const INTERVAL: f64 = 1.96;

/// Distribution of a figure over draws. Without draws all but the count are `null` in JSON and empty in CSV.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Number of values.
    pub n: usize,
    /// Mean.
    pub mean: f64,
    /// Median: the middle value, or the mean of the middle two.
    pub median: f64,
    /// 95th percentile: the least value that 95 % do not exceed.
    pub p95: f64,
    /// Root mean square.
    pub rms: f64,
}

impl Spread {
    /// Summarises values in any order.
    #[must_use]
    pub fn new(values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        let (median, p95) = match n {
            0 => (f64::NAN, f64::NAN),
            _ => (
                (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0,
                sorted[(19 * n).div_ceil(20) - 1],
            ),
        };
        Self {
            n,
            mean: mean(sorted.iter().copied()),
            median,
            p95,
            rms: rms(sorted),
        }
    }
}

/// A share of draws with its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Share {
    /// Draws with the event.
    pub hits: usize,
    /// All draws.
    pub n: usize,
    /// Share, 0 to 1.
    pub share: f64,
    /// Lower end of the 95 % interval (Wilson 1927).
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl Share {
    /// `hits` of `n` draws.
    #[must_use]
    pub fn new(hits: usize, n: usize) -> Self {
        let (count, share) = (n as f64, hits as f64 / n as f64);
        let z2 = INTERVAL * INTERVAL / count;
        let middle = (share + z2 / 2.0) / (1.0 + z2);
        let half = (z2 * (share * (1.0 - share) + z2 / 4.0)).sqrt() / (1.0 + z2);
        Self {
            hits,
            n,
            share,
            low: (middle - half).max(0.0),
            // Exactly 1 if all hit, despite rounding.
            high: if hits == n { 1.0 } else { middle + half },
        }
    }

    /// The share of a list for which `holds`.
    pub fn counted<T>(list: &[T], holds: impl Fn(&T) -> bool) -> Self {
        Self::new(list.iter().filter(|one| holds(one)).count(), list.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_by_hand() {
        let spread = Spread::new([4.0, 1.0, 3.0, 2.0]);
        assert_eq!(
            (spread.n, spread.mean, spread.median, spread.p95),
            (4, 2.5, 2.5, 4.0)
        );
        assert_eq!(spread.rms, 7.5f64.sqrt());
        // The 95th of a hundred, the 19th of twenty.
        assert_eq!(Spread::new((1..=100).map(f64::from)).p95, 95.0);
        assert_eq!(Spread::new((1..=20).map(f64::from)).p95, 19.0);
        let none = Spread::new([]);
        assert!(none.n == 0 && none.mean.is_nan() && none.median.is_nan() && none.p95.is_nan());
    }

    #[test]
    fn shares_have_wilsons_interval() {
        // By hand: 0 of 10 leaves up to z2 / (10 + z2) = 0.2775.
        let none = Share::new(0, 10);
        assert!(none.low == 0.0 && (none.high - 0.277_5).abs() < 1e-4);
        let all = Share::new(10, 10);
        assert!(all.high == 1.0 && (all.low - 0.722_5).abs() < 1e-4);
        let half = Share::new(50, 100);
        assert!((half.low + half.high - 1.0).abs() < 1e-12);
        assert!((half.low - 0.403_8).abs() < 1e-3, "{}", half.low);
    }
}
