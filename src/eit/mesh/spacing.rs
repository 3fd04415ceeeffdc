//! Points along a line, dense where the field is singular.

use super::size::MeshSize;

/// Coordinates that include all `breaks` (ascending, from end to end). The spacing is `fine_mm` at the points of `singular`,
/// grows with the distance from them and never exceeds `coarse_mm`. Between two breaks, points divide the integral of
/// 1 / spacing evenly.
pub(super) fn graded(breaks: &[f64], singular: &[f64], size: MeshSize) -> Vec<f64> {
    const SAMPLES: usize = 64;
    let spacing = |x: f64| {
        let distance = singular
            .iter()
            .map(|s| (x - s).abs())
            .fold(f64::INFINITY, f64::min);
        (size.fine_mm + size.growth * distance).min(size.coarse_mm)
    };
    let mut points = vec![breaks[0]];
    for pair in breaks.windows(2) {
        let (start, length) = (pair[0], pair[1] - pair[0]);
        let step = length / SAMPLES as f64;
        let mut filled = [0.0; SAMPLES + 1];
        for i in 0..SAMPLES {
            filled[i + 1] = filled[i] + step / spacing(start + (i as f64 + 0.5) * step);
        }
        let pieces = libm::ceil(filled[SAMPLES] - 1e-9).max(1.0) as usize;
        let mut sample = 0;
        for piece in 1..pieces {
            let target = filled[SAMPLES] * piece as f64 / pieces as f64;
            while filled[sample + 1] < target {
                sample += 1;
            }
            let share = (target - filled[sample]) / (filled[sample + 1] - filled[sample]);
            points.push(start + (sample as f64 + share) * step);
        }
        points.push(pair[1]);
    }
    points
}

/// Sorts coordinates and removes duplicates within a thousandth of a millimetre.
pub(super) fn distinct(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values.dedup_by(|b, a| (*b - *a).abs() < 1e-3);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn spacing_keeps_its_bounds(
            breaks in proptest::collection::vec(0.0..50.0f64, 2..8),
            coarse in 0.5..4.0f64,
        ) {
            let breaks = distinct(breaks);
            prop_assume!(breaks.len() >= 2);
            let size = MeshSize { coarse_mm: coarse, fine_mm: coarse / 5.0, growth: 0.4, mirrored: false };
            let points = graded(&breaks, &breaks, size);
            prop_assert!(points.windows(2).all(|pair| pair[1] > pair[0]));
            prop_assert!(points.windows(2).all(|pair| pair[1] - pair[0] <= coarse + 1e-9));
            for x in &breaks {
                prop_assert!(points.iter().any(|point| point == x));
            }
        }
    }
}
