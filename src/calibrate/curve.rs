//! Learning curve: the error against the number of presses, extrapolated to twice as many.

use super::error::CalibrateError;
use super::error::FEWEST_PRESSES;
use super::presses::{Presses, shuffled};

/// Least predicted ratio of the error after doubling the presses; a curve of three points is weak evidence.
const LEAST_RATIO: f64 = 0.5;

/// Errors at increasing numbers of presses.
#[derive(Clone, Debug, PartialEq)]
pub struct LearningCurve {
    /// Number of presses and mean error with them, mm; ascending, the last point with all.
    pub points: Vec<(usize, f64)>,
    /// Expected mean error with twice as many presses, mm; `None` if the curve has one point.
    pub twice_mm: Option<f64>,
}

/// The errors that `error` returns for a quarter, half and all of the presses.
///
/// # Errors
/// Those of `error`.
pub fn learning_curve(
    presses: &Presses,
    error: &mut dyn FnMut(&Presses) -> Result<f64, CalibrateError>,
) -> Result<LearningCurve, CalibrateError> {
    let order = shuffled(presses.len());
    let mut points = Vec::new();
    for part in [4, 2, 1] {
        let count = presses.len() / part;
        if count < FEWEST_PRESSES {
            continue;
        }
        let list = order[..count]
            .iter()
            .map(|index| presses.list()[*index].clone())
            .collect();
        // A part that is refused, e.g. because it lies on one line, is left out.
        if let Ok(some) = Presses::new("a part", list) {
            points.push((count, error(&some)?));
        }
    }
    let twice_mm = match points[..] {
        [.., (_, half), (_, all)] => Some(all * (all / half).clamp(LEAST_RATIO, 1.0)),
        _ => None,
    };
    Ok(LearningCurve { points, twice_mm })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::Press;

    #[test]
    fn an_error_that_falls_with_the_root_is_extrapolated() {
        let list = (0..64)
            .map(|i| Press {
                place_mm: [f64::from(i % 8), f64::from(i / 8)],
                modelled: None,
                changes: vec![f64::from(i)],
            })
            .collect();
        let presses = Presses::new("p", list).expect("spread");
        let curve = learning_curve(&presses, &mut |some| Ok(16.0 / (some.len() as f64).sqrt()))
            .expect("sound");
        let counts: Vec<usize> = curve.points.iter().map(|(count, _)| *count).collect();
        assert_eq!(counts, [16, 32, 64]);
        let twice = curve.twice_mm.expect("three points");
        assert!((twice - 16.0 / 128.0_f64.sqrt()).abs() < 1e-9);
    }
}
