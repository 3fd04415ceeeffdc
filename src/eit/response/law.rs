//! How a response grows with the strength of its touch.
//!
//! A spot in a conductor changes a reading by rise / (1 + b rise) to first approximation, b between 0 and 1: 1 where the spot fills
//! a channel, 0 where it lies along the current, 1/2 for a disc in an even sheet (Jackson, Classical Electrodynamics, section 4.4, in two
//! dimensions). Divided by the rise, that is nearly a straight line in rise / (rise + 2.5) for every such b, from the faintest touch on, so
//! few terms describe it: on the shipped lattice they are off by 0.3 % of a response, where three terms of a polynomial in the strength are off
//! by 0.6 %, and by 3 to 7 % of a faint response.

use super::terms::POWERS;
use super::touch_model::{HALF_RISE, MOST_STRENGTH};

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
    /// The factor of each term, divided by the strength.
    pub(super) fn factors_per_strength(self, strength: f64) -> [f64; POWERS] {
        if strength > 0.0 {
            self.factors(strength).map(|[factor, _]| factor / strength)
        } else {
            self.factors(0.0).map(|[_, slope]| slope)
        }
    }

    /// The factor of each term and its derivative by the strength. Beyond [`MOST_STRENGTH`], which the middle of a ring may reach, the
    /// rise goes to infinity: there it continues straight.
    pub(super) fn factors(self, strength: f64) -> [[f64; 2]; POWERS] {
        let s = strength;
        match self {
            Self::Rise if s > MOST_STRENGTH => {
                let last = self.factors(MOST_STRENGTH);
                last.map(|[factor, slope]| [factor + slope * (s - MOST_STRENGTH), slope])
            }
            Self::Rise => {
                let rise = HALF_RISE * s / (1.0 - s);
                let slope = HALF_RISE / ((1.0 - s) * (1.0 - s));
                let v = rise / (rise + MIDDLE_RISE);
                let mut power = 1.0;
                std::array::from_fn(|k| {
                    let factor = [rise * power, slope * power * (1.0 + k as f64 * (1.0 - v))];
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
        fn slopes_are_those_of_the_factors(strength in -2.4..1.6f64, is_of_rise in any::<bool>()) {
            let law = if is_of_rise { StrengthLaw::Rise } else { StrengthLaw::Strength };
            let per_strength = law.factors_per_strength(strength);
            let [before, after] = [-1e-5, 1e-5].map(|by| law.factors(strength + by));
            for (power, [factor, slope]) in law.factors(strength).into_iter().enumerate() {
                if strength > 0.0 {
                    prop_assert!((strength * per_strength[power] - factor).abs() < 1e-9);
                }
                let seen = (after[power][0] - before[power][0]) / 2e-5;
                prop_assert!((seen - slope).abs() < 1e-3, "{power}: {seen} for {slope}");
            }
        }
    }
}
