//! A touch as the table describes it: where, how wide, how strong, and of which shape.

use crate::pad::TouchSign;
use crate::types::PointMm;

/// Unknowns of a shape.
pub const SHAPE_UNKNOWNS: usize = 3;
/// Longest half of a long finger between the middles of its parts, mm.
const LONGEST_MM: f64 = 11.0;
/// Most stretch.
const MOST_STRETCH: f64 = 0.6;
/// Longest half of a palm between the middles of its parts, mm.
const LONGEST_PALM_MM: f64 = 18.0;
/// Widest half of a palm between the middles of its parts, mm: wider, its two rows would be two fingers.
const WIDEST_PALM_MM: f64 = 4.5;
/// Widest ring between the middles of its parts, mm.
const WIDEST_MM: f64 = 9.0;
/// Least and most strength of a ring's middle: that of the parts which overlap there is reduced.
const MIDDLE: [f64; 2] = [-3.0, 2.0];

/// The rise of conductivity that has strength 0.5: strength = rise / (rise + this).
pub(super) const HALF_RISE: f64 = 1.5;
/// Largest strength that the table covers: a rise of 6.
pub const MOST_STRENGTH: f64 = 0.8;

/// A touch as the table describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchModel {
    /// Centre, mm.
    pub centre_mm: PointMm,
    /// Natural logarithm of the radius in mm.
    pub log_radius: f64,
    /// rise / (rise + 1.5): 0 for no touch, 1 for a perfect conductor, or insulator.
    pub strength: f64,
    /// Whether the touch multiplies the conductivity by 1 + rise or divides it. A table of one sign ignores this.
    pub sign: TouchSign,
    /// Whether it is round.
    pub shape: Shape,
}

impl TouchModel {
    /// Relative rise of conductivity at the centre, or of resistivity where it falls.
    #[must_use]
    pub fn rise(&self) -> f64 {
        HALF_RISE * self.strength / (1.0 - self.strength)
    }
}

/// The strength of a relative rise of conductivity.
#[must_use]
pub fn strength_from_rise(rise: f64) -> f64 {
    rise / (rise + HALF_RISE)
}

/// The shape of a touch. Its log radius and strength are those of its middle, of a ring those of its parts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Shape {
    /// A paraboloid.
    #[default]
    Round,
    /// Longer than wide.
    Long {
        /// From the centre to the middle of the outermost part, mm.
        half_mm: [f64; 2],
        /// How much less it saturates along its axis than across it, from 0.
        stretch: f64,
    },
    /// Longer than wide, and wider than the table: the heel of a hand, or a fist.
    Palm {
        /// From the centre to the middle of the outermost parts, along it, mm.
        half_mm: [f64; 2],
        /// From the centre to the middle of the parts, across it, mm.
        width_mm: f64,
    },
    /// A ring, or a finger wider than the table.
    Ring {
        /// From the centre to the middle of the parts, mm.
        radius_mm: f64,
        /// Strength of the middle as a multiple of that of a part.
        middle: f64,
    },
}

impl Shape {
    /// The unknowns; of a ring, the second counts nothing.
    #[must_use]
    pub fn unknowns(self) -> [f64; SHAPE_UNKNOWNS] {
        match self {
            Self::Round => [0.0; SHAPE_UNKNOWNS],
            Self::Long {
                half_mm: [x, y],
                stretch,
            } => [x, y, stretch],
            Self::Palm {
                half_mm: [x, y],
                width_mm,
            } => [x, y, width_mm],
            Self::Ring { radius_mm, middle } => [radius_mm, 0.0, middle],
        }
    }

    /// The shape of this kind with other unknowns, within what is possible.
    #[must_use]
    pub fn with_unknowns(self, [first, second, third]: [f64; SHAPE_UNKNOWNS]) -> Self {
        match self {
            Self::Round => Self::Round,
            Self::Long { .. } => Self::Long {
                half_mm: shortened([first, second], LONGEST_MM),
                stretch: third.clamp(0.0, MOST_STRETCH),
            },
            Self::Palm { .. } => Self::Palm {
                half_mm: shortened([first, second], LONGEST_PALM_MM),
                width_mm: third.clamp(0.0, WIDEST_PALM_MM),
            },
            Self::Ring { .. } => Self::Ring {
                radius_mm: first.clamp(0.0, WIDEST_MM),
                middle: third.clamp(MIDDLE[0], MIDDLE[1]),
            },
        }
    }
}

/// A vector of at most a length.
fn shortened(vector: [f64; 2], most: f64) -> [f64; 2] {
    let excess = (libm::hypot(vector[0], vector[1]) / most).max(1.0);
    vector.map(|part| part / excess)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rise_and_strength_are_each_other() {
        for rise in [0.0, 0.3, 1.0, 5.0] {
            let touch = TouchModel {
                centre_mm: [0.0; 2],
                log_radius: 0.0,
                strength: strength_from_rise(rise),
                sign: TouchSign::Rise,
                shape: Shape::Round,
            };
            assert!((touch.rise() - rise).abs() < 1e-12);
        }
    }
}
