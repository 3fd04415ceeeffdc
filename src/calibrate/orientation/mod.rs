//! Which way round a pad is wired: found from three presses at shown places.
//!
//! Turning or mirroring a square's electrodes changes no reading at rest and no reciprocity, so a board that is plugged in
//! a quarter turned, or from below, looks sound and shows every touch in the wrong place. Three presses at places that are
//! told apart by every turn and mirror settle it: for each numbering of the electrodes the frame is put into the pad's
//! order and held against what the model says a press there does. The numbering under which all three fit is the board's.
//!
//! A press is held against the model by the cosine between both changes, each reading weighted by its noise: force and size
//! of the finger cancel. The finger may miss the shown place by `MISS_MM`; the best place within counts.

mod presses;
mod text;

pub use presses::{Progress, ThreePresses};
pub use text::{NumberingTextError, numbered};

use crate::eit::{Linearised, SetupError};
use crate::pad::{Numbering, Outline, Pad, Renumbered};
use crate::types::PointMm;

/// Shown places lie this share of the pad's sides from its edge ...
const INSET_SHARE: f64 = 0.22;
/// ... and on a round pad this share of the radius from its centre.
const ROUND_SHARE: f64 = 0.65;
/// A person misses a shown place by so much at most, mm, or as a share of the pad's shorter side.
const MISS_MM: f64 = 10.0;
const MISS_SHARE: f64 = 0.1;
/// Steps across the circle in which the finger is looked for.
const STEPS: i32 = 2;
/// A fingertip, mm, as far as the pad is large enough for it.
const FINGER_MM: f64 = 7.0;
/// Presses that fit worse than this (mean squared cosine) fit no numbering: the order of the readings is another, or
/// something else pressed the pad. The simulated pad shows 0.7 and more at 40 dB for the right one.
const LEAST_FIT: f64 = 0.25;
/// What is left over under the second best numbering is at least this many times what is left under the best.
const LEAST_RATIO: f64 = 1.5;

/// What three presses say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WhichWay {
    /// How the board numbers the places of the pad's text.
    pub numbering: Numbering,
    /// How well it fits, 0 to 1: mean squared cosine.
    pub fit: f64,
    /// How well the next best fits.
    pub next: f64,
}

/// Why they say nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WhichWayError {
    /// The model makes nothing of the presses.
    #[error(
        "the presses fit no numbering of the electrodes (best {:.0} %): press the shown places with one finger; if it stays so, the order of the readings is another or an electrode is loose",
        100.0 * .0
    )]
    NoneFits(f64),
    /// Two numberings fit alike.
    #[error(
        "the presses fit two numberings alike ({:.0} and {:.0} %): press harder, and nearer to the shown places",
        100.0 * .0, 100.0 * .1
    )]
    Ambiguous(f64, f64),
    /// The board does not read what a renumbered one would.
    #[error(
        "the pad lists its readings one by one: they cannot be renumbered; change its `channels` by hand"
    )]
    Listed,
}

/// One press as the board told it.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownPress {
    /// Where the place was shown, mm.
    pub place_mm: PointMm,
    /// (v - v0) / v0 of every reading, in the order of the board; not finite where v0 is zero.
    pub changes: Vec<f64>,
}

/// Where to press, in turn: three places that no turn and no mirror of the pad maps onto each other in order.
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

/// The model's answers to presses near the shown places.
#[derive(Clone, Debug)]
pub struct Orienter {
    places_mm: [PointMm; 3],
    /// For each shown place, the change of every reading by a press at each place around it.
    expected: [Vec<Vec<f64>>; 3],
    numberings: Vec<(Numbering, Renumbered)>,
    /// How the pad's text numbers its electrodes already.
    declared: Numbering,
    electrodes: usize,
    channels: usize,
}

impl Orienter {
    /// Solves the pad's model.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    pub fn new(pad: &Pad) -> Result<Self, SetupError> {
        let linearised = Linearised::of_pad(pad)?;
        let places_mm = shown_places(&pad.outline);
        let sign = f64::from(pad.touch_sign.factor());
        let size = pad.outline.size_mm();
        let shorter_mm = size[0].min(size[1]);
        let (miss_mm, finger_mm) = (
            MISS_MM.min(MISS_SHARE * shorter_mm),
            FINGER_MM.max(0.05 * shorter_mm).min(0.15 * shorter_mm),
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

    /// Where to press, in turn.
    #[must_use]
    pub fn places_mm(&self) -> [PointMm; 3] {
        self.places_mm
    }

    /// The numbering that explains presses at the shown places, in their order; `deviations` is the relative noise of each
    /// reading.
    ///
    /// # Errors
    /// See [`WhichWayError`].
    ///
    /// # Panics
    /// If a press or the deviations have another number of readings than the pad.
    pub fn find(
        &self,
        presses: &[ShownPress; 3],
        deviations: &[f64],
    ) -> Result<WhichWay, WhichWayError> {
        assert_eq!(deviations.len(), self.channels);
        let mut fits: Vec<(f64, Numbering)> = self
            .numberings
            .iter()
            .map(|(numbering, renumbered)| {
                let fit = presses.iter().zip(&self.expected).map(|(press, expected)| {
                    assert_eq!(press.changes.len(), self.channels);
                    let of = |values: &[f64]| -> Vec<f64> {
                        renumbered.source().map(|index| values[index]).collect()
                    };
                    let (changes, deviations) = (of(&press.changes), of(deviations));
                    let cosines = expected
                        .iter()
                        .map(|expected| cosine(&changes, expected, &deviations));
                    let best = cosines.fold(0.0, f64::max);
                    best * best
                });
                (fit.sum::<f64>() / presses.len() as f64, *numbering)
            })
            .collect();
        // Stable: of equals, the one that needs no change comes first.
        fits.sort_by(|a, b| b.0.total_cmp(&a.0));
        let [(fit, numbering), (next, _), ..] = fits[..] else {
            return Err(WhichWayError::Listed);
        };
        if fit < LEAST_FIT {
            return Err(WhichWayError::NoneFits(fit));
        }
        if 1.0 - next < LEAST_RATIO * (1.0 - fit) {
            return Err(WhichWayError::Ambiguous(fit, next));
        }
        Ok(WhichWay {
            numbering: numbering.within(self.declared, self.electrodes),
            fit,
            next,
        })
    }
}

/// Places on a square lattice in a circle.
fn around([x, y]: PointMm, radius_mm: f64) -> impl Iterator<Item = PointMm> {
    (-STEPS..=STEPS)
        .flat_map(|i| (-STEPS..=STEPS).map(move |j| (i, j)))
        .filter(|(i, j)| i * i + j * j <= STEPS * STEPS)
        .map(move |(i, j)| {
            let mm = |step: i32| f64::from(step) * radius_mm / f64::from(STEPS);
            [x + mm(i), y + mm(j)]
        })
}

/// The linear model's change of every reading by a finger that presses most in its middle.
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

/// Cosine between two changes, each reading weighted by its noise; readings that tell nothing are left out.
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
