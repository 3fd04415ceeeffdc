//! How a response grows with the strength of its touch.
//!
//! A spot in a conductor changes a reading by rise / (1 + b rise) to first approximation, b between 0 and 1: 1 where the spot fills
//! a channel, 0 where it lies along the current, 1/2 for a disc in an even sheet (Jackson, Classical Electrodynamics, section 4.4, in two
//! dimensions). Divided by the rise, that is nearly a straight line in rise / (rise + 2.5) for every such b, from the faintest touch on, so
//! few terms describe it: on the shipped lattice they are off by 0.1 % of a response between the solved strengths and by 0.4 % below
//! them, where a polynomial in the strength is off by 0.6 % and 3 %, of falling touches 7 %.

use super::terms::POWERS;
use super::touch_model::HALF_RISE;

/// The rise in the middle of the polynomial's variable.
pub(super) const MIDDLE_RISE: f64 = 2.5;

/// What the terms of a table are multiplied by, beside the square of the radius.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StrengthLaw {
    /// The rise times powers of rise / (rise + [`MIDDLE_RISE`]).
    Rise,
    /// Powers of the strength, from the first on: in older recordings, and of pads that presses describe, whose responses
    /// are proportional to it.
    Strength,
}

impl StrengthLaw {
    /// The factor of each term and its derivative by the strength.
    pub(super) fn factors(self, strength: f64) -> [[f64; 2]; POWERS] {
        let s = strength;
        match self {
            Self::Rise => {
                let rise = HALF_RISE * s / (1.0 - s);
                let slope = HALF_RISE / ((1.0 - s) * (1.0 - s));
                let v = rise / (rise + MIDDLE_RISE);
                let mut power = 1.0;
                std::array::from_fn(|k| {
                    let factor = [
                        rise * power,
                        slope * power * (1.0 + k as f64 * (1.0 - v)),
                    ];
                    power *= v;
                    factor
                })
            }
            Self::Strength => [[s, 1.0], [s * s, 2.0 * s], [s * s * s, 3.0 * s * s]],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn slopes_are_those_of_the_factors(strength in 0.01..0.79f64, is_of_rise in any::<bool>()) {
            let law = if is_of_rise { StrengthLaw::Rise } else { StrengthLaw::Strength };
            let [before, after] = [-1e-5, 1e-5].map(|by| law.factors(strength + by));
            for (power, [_, slope]) in law.factors(strength).into_iter().enumerate() {
                let seen = (after[power][0] - before[power][0]) / 2e-5;
                prop_assert!((seen - slope).abs() < 1e-6 * slope, "{power}: {seen} for {slope}");
            }
        }
    }
}
