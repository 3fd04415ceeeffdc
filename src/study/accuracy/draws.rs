//! Random touches, pairs of touches and single shapes. The seed and the number of a case determine its draws.
//!
//! Lengths are those of a finger. On a pad below 100 mm all lengths shrink with its shorter side, so that three touches still
//! fit.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;

use crate::pad::{Outline, Pad};
use crate::study::{Press, StudyError};
use crate::types::PointMm;

/// Shorter side of a pad from which lengths are not scaled, mm.
const FULL_SIZE_MM: f64 = 100.0;
/// Radius of a touch, mm: fingertips, from light to hard.
const RADIUS_MM: [f64; 2] = [5.0, 9.0];
/// Relative rise at the centre of a touch, as measured on gels.
const RISE: [f64; 2] = [0.5, 2.0];
/// Least distance between touches of one frame, mm.
const APART_MM: f64 = 30.0;
/// Least distance of the centre of a touch from the edge, mm.
const MARGIN_MM: f64 = 10.0;
/// Radius (mm) and rise of the presses of a pair, and of the single shapes.
pub(super) const PAIR: (f64, f64) = (7.0, 1.0);
/// Half-axes of the ellipse, mm: a finger laid flat.
pub(super) const ELLIPSE_MM: [f64; 2] = [10.0, 6.0];
/// Attempts after which a pad counts as too small for a draw.
const MOST_ATTEMPTS: usize = 100_000;

/// A source of random touches on one pad.
#[derive(Clone, Debug)]
pub(in crate::study) struct Draws {
    random: ChaCha8Rng,
    outline: Outline,
    scale: f64,
}

/// The shape of a single touch that differs from the model of a press.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SingleShape {
    /// Flat, with a sharp edge.
    Disc,
    /// A Gaussian whose deviation is half the radius: same volume as the press.
    Gaussian,
    /// A press with two half-axes.
    Ellipse,
}

/// A single shape at a place and angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedShape {
    shape: SingleShape,
    centre_mm: PointMm,
    angle: f64,
    scale: f64,
}

/// Scale of lengths on a pad: 1 from 100 mm on.
pub(super) fn scale(pad: &Pad) -> f64 {
    let [width, height] = pad.outline.size_mm();
    (width.min(height) / FULL_SIZE_MM).min(1.0)
}

impl Draws {
    pub(in crate::study) fn new(pad: &Pad, seed: u64, stream: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        Self {
            random,
            outline: pad.outline,
            scale: scale(pad),
        }
    }

    pub(super) fn seed(&mut self) -> u64 {
        self.random.next_u64()
    }

    pub(super) fn between(&mut self, least: f64, most: f64) -> f64 {
        let share = (self.random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        least + share * (most - least)
    }

    pub(super) fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    pub(super) fn angle(&mut self) -> f64 {
        self.between(0.0, std::f64::consts::TAU)
    }

    /// Presses at least [`APART_MM`] apart.
    pub(in crate::study) fn presses(&mut self, count: usize) -> Result<Vec<Press>, StudyError> {
        self.presses_apart(count, APART_MM)
    }

    /// Presses whose centres are at least a distance apart, mm before scaling.
    pub(super) fn presses_apart(
        &mut self,
        count: usize,
        apart_mm: f64,
    ) -> Result<Vec<Press>, StudyError> {
        let apart_mm = apart_mm * self.scale;
        for _ in 0..MOST_ATTEMPTS {
            let centres: Vec<PointMm> =
                (0..count).map(|_| self.place()).collect::<Result<_, _>>()?;
            let is_near = |(a, from): (usize, &PointMm)| {
                centres[..a]
                    .iter()
                    .any(|to| libm::hypot(from[0] - to[0], from[1] - to[1]) < apart_mm)
            };
            if !centres.iter().enumerate().any(is_near) {
                let press = |centre_mm| Press {
                    centre_mm,
                    radius_mm: self.scale * self.between(RADIUS_MM[0], RADIUS_MM[1]),
                    rise: self.between(RISE[0], RISE[1]),
                };
                return Ok(centres.into_iter().map(press).collect());
            }
        }
        Err(self.no_room())
    }

    /// Two equal presses at a distance (before scaling), at any place and angle.
    pub(super) fn pair(&mut self, distance_mm: f64) -> Result<Vec<Press>, StudyError> {
        for _ in 0..MOST_ATTEMPTS {
            let [x, y] = self.place()?;
            let angle = self.angle();
            let half = self.scale * distance_mm / 2.0;
            let (dx, dy) = (half * libm::cos(angle), half * libm::sin(angle));
            let centres = [[x - dx, y - dy], [x + dx, y + dy]];
            if centres.iter().all(|centre| self.is_inside(*centre)) {
                let press = |centre_mm| Press {
                    centre_mm,
                    radius_mm: PAIR.0 * self.scale,
                    rise: PAIR.1,
                };
                return Ok(centres.map(press).to_vec());
            }
        }
        Err(self.no_room())
    }

    /// A single shape, at any place and angle.
    pub(super) fn single(&mut self, shape: SingleShape) -> Result<PlacedShape, StudyError> {
        Ok(PlacedShape {
            shape,
            centre_mm: self.place()?,
            angle: self.angle(),
            scale: self.scale,
        })
    }

    /// A place at least [`MARGIN_MM`] from the edge.
    fn place(&mut self) -> Result<PointMm, StudyError> {
        let [width, height] = self.outline.size_mm();
        for _ in 0..MOST_ATTEMPTS {
            let point = [self.between(0.0, width), self.between(0.0, height)];
            if self.is_inside(point) {
                return Ok(point);
            }
        }
        Err(self.no_room())
    }

    fn is_inside(&self, point: PointMm) -> bool {
        is_inside(&self.outline, self.scale, point)
    }

    fn no_room(&self) -> StudyError {
        let [width, height] = self.outline.size_mm();
        StudyError::refused(format!(
            "a pad of {width} x {height} mm is too small for the touches"
        ))
    }
}

/// Whether a touch may have its centre at a point. Outlines are convex: eight directions are enough.
fn is_inside(outline: &Outline, scale: f64, [x, y]: PointMm) -> bool {
    const DIRECTIONS: usize = 8;
    // Slightly less, so that rounding does not exclude places exactly on the margin.
    let margin_mm = MARGIN_MM * scale - 1e-9;
    (0..DIRECTIONS).all(|direction| {
        let angle = std::f64::consts::TAU * direction as f64 / DIRECTIONS as f64;
        outline.contains([
            x + margin_mm * libm::cos(angle),
            y + margin_mm * libm::sin(angle),
        ])
    })
}

/// A regular grid of `side` x `side` places, without those too near the edge.
pub(super) fn grid(pad: &Pad, side: usize) -> Vec<PointMm> {
    let size = pad.outline.size_mm();
    let scale = scale(pad);
    let margin_mm = MARGIN_MM * scale;
    let at = |axis: usize, step: usize| {
        let share = step as f64 / (side - 1) as f64;
        margin_mm + share * (size[axis] - 2.0 * margin_mm)
    };
    (0..side * side)
        .map(|index| [at(0, index % side), at(1, index / side)])
        .filter(|point| is_inside(&pad.outline, scale, *point))
        .collect()
}

impl SingleShape {
    /// All shapes, in the order of reports.
    pub const ALL: [Self; 3] = [Self::Disc, Self::Gaussian, Self::Ellipse];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Disc => "disc",
            Self::Gaussian => "Gaussian",
            Self::Ellipse => "ellipse",
        }
    }
}

impl PlacedShape {
    /// The factor of conductivity at a point.
    pub(super) fn factor(&self, [x, y]: PointMm) -> f64 {
        let (radius, rise) = (PAIR.0 * self.scale, PAIR.1);
        let (dx, dy) = (x - self.centre_mm[0], y - self.centre_mm[1]);
        let height = match self.shape {
            SingleShape::Disc => f64::from(u8::from(dx * dx + dy * dy <= radius * radius)),
            // Cut where it has fallen to e^-8: the rest would only slow down solving.
            SingleShape::Gaussian if dx * dx + dy * dy > 4.0 * radius * radius => 0.0,
            SingleShape::Gaussian => libm::exp(-2.0 * (dx * dx + dy * dy) / (radius * radius)),
            SingleShape::Ellipse => {
                let (sin, cos) = (libm::sin(self.angle), libm::cos(self.angle));
                let u = (dx * cos + dy * sin) / (ELLIPSE_MM[0] * self.scale);
                let v = (dy * cos - dx * sin) / (ELLIPSE_MM[1] * self.scale);
                (1.0 - u * u - v * v).max(0.0)
            }
        };
        1.0 + rise * height
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::shipped_pad;
    use proptest::prelude::*;

    fn pad(outline: Outline) -> Pad {
        let shipped = shipped_pad("edinburgh-solid").expect("shipped");
        Pad {
            outline,
            ..Pad::from_toml(shipped.name, shipped.toml).expect("sound")
        }
    }

    fn outlines() -> impl Strategy<Value = Outline> {
        prop_oneof![
            (15.0..400.0f64, 15.0..400.0f64).prop_map(|(width_mm, height_mm)| {
                Outline::Rectangle {
                    width_mm,
                    height_mm,
                }
            }),
            (10.0..300.0f64).prop_map(|radius_mm| Outline::Circle { radius_mm }),
        ]
    }

    proptest! {
        #[test]
        fn touches_lie_on_any_pad_and_apart(outline in outlines(), seed: u64) {
            let pad = pad(outline);
            let scale = scale(&pad);
            let mut draws = Draws::new(&pad, seed, 0);
            let three = draws.presses(3).expect("room");
            for (index, press) in three.iter().enumerate() {
                prop_assert!(outline.contains(press.centre_mm));
                for other in &three[..index] {
                    let [dx, dy] = [0, 1].map(|i| press.centre_mm[i] - other.centre_mm[i]);
                    prop_assert!(dx.hypot(dy) >= 30.0 * scale);
                }
            }
            let pair = draws.pair(40.0).expect("room");
            let [dx, dy] = [0, 1].map(|i| pair[0].centre_mm[i] - pair[1].centre_mm[i]);
            prop_assert!((dx.hypot(dy) / scale - 40.0).abs() < 1e-9);
            prop_assert!(grid(&pad, 4).iter().all(|point| outline.contains(*point)));
        }
    }

    #[test]
    fn seeds_and_streams_differ_and_a_square_keeps_its_whole_grid() {
        let pad = pad(Outline::Rectangle {
            width_mm: 100.0,
            height_mm: 100.0,
        });
        let first = |seed, stream| Draws::new(&pad, seed, stream).seed();
        assert_eq!(first(1, 3), first(1, 3));
        assert_ne!(first(1, 3), first(1, 4));
        assert_ne!(first(1, 3), first(2, 3));
        assert_eq!(grid(&pad, 7).len(), 49);
    }

    #[test]
    fn single_shapes_have_their_heights() {
        let placed = |shape| PlacedShape {
            shape,
            centre_mm: [50.0, 50.0],
            angle: std::f64::consts::FRAC_PI_2,
            scale: 1.0,
        };
        let near = |a: f64, b: f64| (a - b).abs() < 1e-6;
        assert!(near(placed(SingleShape::Disc).factor([50.0, 56.9]), 2.0));
        assert!(near(placed(SingleShape::Disc).factor([50.0, 57.1]), 1.0));
        // One deviation out: e^-1/2.
        assert!(near(
            placed(SingleShape::Gaussian).factor([53.5, 50.0]),
            1.606_530_66
        ));
        // Turned by a right angle, its long axis is upright.
        assert!(near(
            placed(SingleShape::Ellipse).factor([50.0, 55.0]),
            1.75
        ));
        assert!(near(placed(SingleShape::Ellipse).factor([56.1, 50.0]), 1.0));
    }
}
