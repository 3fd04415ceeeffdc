//! How the error falls with the number of presses, and what more of them would bring.

use super::CalibrateError;
use super::presses::{FEWEST_PRESSES, Presses, mixed};

/// Doubling the presses is never foretold to lower the error below this share: a curve of three points is no proof.
const BEST_FORETOLD: f64 = 0.5;

/// Errors at growing numbers of presses.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Presses and the mean error with them, mm; ascending, the last with all.
    pub points: Vec<(usize, f64)>,
    /// The mean error to expect with twice as many, mm; none where the curve has one point.
    pub twice_mm: Option<f64>,
}

/// Errors with a quarter, half and all of the presses, as `error` tells them.
///
/// # Errors
/// What `error` gives.
pub fn learning_curve(
    presses: &Presses,
    error: &mut dyn FnMut(&Presses) -> Result<f64, CalibrateError>,
) -> Result<Curve, CalibrateError> {
    let order = mixed(presses.len());
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
        // A part that lies on one line teaches nothing: it is no point of the curve.
        if let Ok(some) = Presses::new("a part", list) {
            points.push((count, error(&some)?));
        }
    }
    let twice_mm = match points[..] {
        [.., (_, half), (_, all)] => Some(all * (all / half).clamp(BEST_FORETOLD, 1.0)),
        _ => None,
    };
    Ok(Curve { points, twice_mm })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::Press;

    #[test]
    fn an_error_that_falls_with_the_root_is_foretold() {
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
