//! Compares three presses with the model under every numbering of the electrodes.
//!
//! For each numbering, a press is put into the pad's order and compared with the model's press at the shown place. The
//! measure is the cosine between both changes, each reading weighted by its noise, so force and size of the finger cancel.
//! The finger may miss the shown place by [`MISS_MM`]; the best place within that distance counts.

use crate::calibrate::presses::Press;
use crate::eit::{Linearised, SetupError};
use crate::pad::{Numbering, Outline, Pad, Renumbered};
use crate::types::PointMm;

/// Distance of the shown places from the edge, as a share of the pad's sides.
const INSET_SHARE: f64 = 0.22;
/// On a round pad: their distance from the centre, as a share of the radius.
const ROUND_SHARE: f64 = 0.65;
/// A finger misses a shown place by at most this many mm, or this share of the pad's shorter side, whichever is less.
const MISS_MM: f64 = 10.0;
const MISS_SHARE: f64 = 0.1;
/// Steps of the search across the radius of the circle of misses.
const STEPS: i32 = 2;
/// Radius of a fingertip, mm, ...
const FINGER_MM: f64 = 7.0;
/// ... kept within these shares of the pad's shorter side: less on a small pad, more on a large one.
const FINGER_SHARES: [f64; 2] = [0.05, 0.15];
/// Least mean squared cosine of a numbering that fits. Below it, the readings have another order or something else pressed
/// the pad. On the simulated pad the right numbering reaches 0.7 at 40 dB.
const LEAST_FIT: f64 = 0.25;
/// What the second best numbering leaves unexplained is at least this many times what the best one leaves.
const LEAST_RATIO: f64 = 1.5;

/// The numbering that fits three presses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orientation {
    /// How the board numbers the places in the pad's text.
    pub numbering: Numbering,
    /// Mean squared cosine, 0 to 1.
    pub fit: f64,
    /// The same for the second best numbering.
    pub next: f64,
}

/// Why no numbering was found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OrientationError {
    /// The presses fit no numbering; the best fit, 0 to 1.
    #[error(
        "the presses fit no numbering of the electrodes (best {:.0} %): press the shown places with one finger; if that does not help, the readings come in another order or an electrode is loose",
        100.0 * .0
    )]
    NoneFits(f64),
    /// Two numberings fit about equally; both fits, 0 to 1.
    #[error(
        "the presses fit two numberings about equally ({:.0} and {:.0} %): press harder, and closer to the shown places",
        100.0 * .0, 100.0 * .1
    )]
    Ambiguous(f64, f64),
    /// The pad's measurement pattern is a list that cannot be renumbered.
    #[error(
        "the pad file lists its channels one by one, so they cannot be renumbered: change `channels` by hand"
    )]
    Listed,
}

/// The three places to press, in order: no turn or mirror of the pad maps them onto themselves.
#[must_use]
pub fn shown_places(outline: &Outline) -> [PointMm; 3] {
    match *outline {
        Outline::Rectangle {
            width_mm,
            height_mm,
        } => {
            let (left, right) = (INSET_SHARE * width_mm, (1.0 - INSET_SHARE) * width_mm);
            let (low, high) = (INSET_SHARE * height_mm, (1.0 - INSET_SHARE) * height_mm);
            [[left, low], [right, low], [right, high]]
        }
        Outline::Circle { radius_mm } => {
            let off = ROUND_SHARE * radius_mm * core::f64::consts::FRAC_1_SQRT_2;
            let (low, high) = (radius_mm - off, radius_mm + off);
            [[low, low], [high, low], [high, high]]
        }
    }
}

/// The model's changes for presses near the shown places.
#[derive(Clone, Debug)]
pub struct OrientationSolver {
    places_mm: [PointMm; 3],
    /// For each shown place: the changes of all readings by a press at each place around it.
    expected: [Vec<Vec<f64>>; 3],
    numberings: Vec<(Numbering, Renumbered)>,
    /// The numbering in the pad's text.
    declared: Numbering,
    electrodes: usize,
    channels: usize,
}

impl OrientationSolver {
    /// Solves the pad's forward model.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    pub fn new(pad: &Pad) -> Result<Self, SetupError> {
        let linearised = Linearised::from_pad(pad)?;
        let places_mm = shown_places(&pad.outline);
        let sign = f64::from(pad.touch_sign.factor());
        let size = pad.outline.size_mm();
        let shorter_mm = size[0].min(size[1]);
        let (miss_mm, finger_mm) = (
            MISS_MM.min(MISS_SHARE * shorter_mm),
            FINGER_MM
                .max(FINGER_SHARES[0] * shorter_mm)
                .min(FINGER_SHARES[1] * shorter_mm),
        );
        let electrodes = pad.electrodes.len();
        Ok(Self {
            places_mm,
            expected: places_mm.map(|place_mm| {
                around(place_mm, miss_mm)
                    .map(|at_mm| response(&linearised, at_mm, finger_mm, sign))
                    .collect()
            }),
            numberings: Numbering::all(electrodes)
                .filter_map(|numbering| {
                    Some((numbering, Renumbered::new(&pad.protocol, numbering)?))
                })
                .collect(),
            declared: pad.numbering,
            electrodes,
            channels: pad.channels(),
        })
    }

    /// The three places to press, in order, mm.
    #[must_use]
    pub fn places_mm(&self) -> [PointMm; 3] {
        self.places_mm
    }

    /// Readings in a frame.
    pub(super) fn channels(&self) -> usize {
        self.channels
    }

    /// Finds the numbering that explains presses at the shown places, in their order. The changes of a press are
    /// (v - v0) / v0 in the board's order, not finite where v0 is 0. `deviations` is the relative noise of each reading.
    ///
    /// # Errors
    /// See [`OrientationError`].
    ///
    /// # Panics
    /// If a press or the deviations have another number of readings than the pad.
    pub fn find(
        &self,
        presses: [&Press; 3],
        deviations: &[f64],
    ) -> Result<Orientation, OrientationError> {
        assert_eq!(deviations.len(), self.channels);
        let mut fits: Vec<(f64, Numbering)> = self
            .numberings
            .iter()
            .map(|(numbering, renumbered)| {
                let fit = presses.iter().zip(&self.expected).map(|(press, expected)| {
                    assert_eq!(press.changes.len(), self.channels);
                    let in_pad_order = |values: &[f64]| -> Vec<f64> {
                        renumbered
                            .board_indices()
                            .map(|index| values[index])
                            .collect()
                    };
                    let (changes, deviations) =
                        (in_pad_order(&press.changes), in_pad_order(deviations));
                    let cosines = expected
                        .iter()
                        .map(|expected| cosine(&changes, expected, &deviations));
                    let best = cosines.fold(0.0, f64::max);
                    best * best
                });
                (fit.sum::<f64>() / presses.len() as f64, *numbering)
            })
            .collect();
        // A stable sort: of equal fits, the numbering that changes nothing comes first.
        fits.sort_by(|a, b| b.0.total_cmp(&a.0));
        let [(fit, numbering), (next, _), ..] = fits[..] else {
            return Err(OrientationError::Listed);
        };
        if fit < LEAST_FIT {
            return Err(OrientationError::NoneFits(fit));
        }
        if 1.0 - next < LEAST_RATIO * (1.0 - fit) {
            return Err(OrientationError::Ambiguous(fit, next));
        }
        Ok(Orientation {
            numbering: numbering.compose(self.declared, self.electrodes),
            fit,
            next,
        })
    }
}

/// Places of a square lattice within a circle.
fn around([x, y]: PointMm, radius_mm: f64) -> impl Iterator<Item = PointMm> {
    (-STEPS..=STEPS)
        .flat_map(|i| (-STEPS..=STEPS).map(move |j| (i, j)))
        .filter(|(i, j)| i * i + j * j <= STEPS * STEPS)
        .map(move |(i, j)| {
            let mm = |step: i32| f64::from(step) * radius_mm / f64::from(STEPS);
            [x + mm(i), y + mm(j)]
        })
}

/// Change of every reading by a finger that presses hardest in its middle, from the linearised model.
fn response(linearised: &Linearised, [x, y]: PointMm, radius_mm: f64, sign: f64) -> Vec<f64> {
    let mut changes = vec![0.0; linearised.jacobian.nrows()];
    for (column, pixel) in linearised.active.iter().enumerate() {
        let centre = linearised.grid.centre_mm(*pixel);
        let [dx, dy] = [centre[0] - x, centre[1] - y];
        let press = 1.0 - (dx * dx + dy * dy) / (radius_mm * radius_mm);
        if press > 0.0 {
            for (change, entry) in changes
                .iter_mut()
                .zip(linearised.jacobian.col(column).iter())
            {
                *change += sign * press * entry;
            }
        }
    }
    changes
}

/// Cosine between two changes, each reading weighted by its noise. Readings that are not finite are left out.
fn cosine(a: &[f64], b: &[f64], deviations: &[f64]) -> f64 {
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for ((a, b), deviation) in a.iter().zip(b).zip(deviations) {
        let weight = 1.0 / (deviation * deviation);
        if a.is_finite() && weight.is_finite() {
            ab += weight * a * b;
            aa += weight * a * a;
            bb += weight * b * b;
        }
    }
    let norm = libm::sqrt(aa * bb);
    if norm > 0.0 { ab / norm } else { 0.0 }
}
