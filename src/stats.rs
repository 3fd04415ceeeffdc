//! Summary statistics of samples in memory.

/// Mean; NaN of no values.
pub fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values
        .into_iter()
        .fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// Root mean square; NaN of no values.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    libm::sqrt(mean(values.into_iter().map(|value| value * value)))
}

/// Least and greatest value; an empty range (infinity, -infinity) of no values.
pub fn range(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let start = [f64::INFINITY, f64::NEG_INFINITY];
    values.into_iter().fold(start, |[least, most], value| {
        [least.min(value), most.max(value)]
    })
}

/// The quantile at a share from 0 to 1, by nearest rank: always one of the values. At 0.5 the median, the upper one of the
/// middle two. `None` of no values.
pub fn quantile(values: impl IntoIterator<Item = f64>, share: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    Some(sorted[libm::round(share * last as f64) as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_by_hand() {
        assert_eq!(mean([1.0, 2.0, 6.0]), 3.0);
        assert_eq!(rms([3.0, -3.0, 3.0]), 3.0);
        assert_eq!(range([2.0, -1.0, 5.0]), [-1.0, 5.0]);
        assert!(mean([]).is_nan() && rms([]).is_nan());
    }

    #[test]
    fn quantiles_are_values() {
        let values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!(quantile(values, 0.5), Some(3.0), "the upper median");
        assert_eq!(quantile(values, 0.0), Some(1.0));
        assert_eq!(quantile(values, 1.0), Some(4.0));
        assert_eq!(quantile([5.0, 1.0, 2.0], 0.5), Some(2.0));
        assert_eq!(quantile([], 0.5), None);
    }
}
