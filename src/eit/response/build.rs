//! Solves a pad's response table, one row of places at a time.
//!
//! Rows are independent of each other: a caller may solve them on several threads and show progress; the table is the
//! same bit for bit.

use faer::linalg::solvers::SelfAdjointEigen;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use std::sync::Arc;

use super::LANES;
use super::derived::DerivedResponses;
use super::law::{MIDDLE_RISE, StrengthLaw};
use super::learned::LearnedResponses;
use super::places::{self, Places, RADII};
use super::quantized::{self, STEP_LOG2};
use super::scatter::{self, LinearResponses, Scatterer};
use super::stretch::{self, Stretches};
use super::symmetry::Orbits;
use super::table::ResponseTable;
use super::terms::{POWERS, SIGNS, Terms};
use super::touch_model::HALF_RISE;
use crate::eit::SetupError;
use crate::pad::Pad;

/// Part of the key. Raise it when the solver changes in a way that [`solver_constants`], which are part of the key too, do not
/// show.
const VERSION: u32 = 10;
/// Strengths whose responses of either sign a table is made from: the faintest touch, which the Jacobian gives, and rises of 1.2 and
/// 4.3.
const STRENGTHS: [f64; POWERS] = [0.0, 0.44, 0.74];
/// Radii that are solved; the smallest and the largest are extrapolated from them.
const SOLVED: usize = RADII - 2;
/// Samples per place: radii x signs x strengths.
const SAMPLES: usize = SOLVED * SIGNS * POWERS;
/// Dimensions with less than this share of the responses' energy are left out: 90 dB below the total.
const LEAST_SHARE: f64 = 1e-9;
/// A table has up to this many dimensions, unless those left out hold more than [`LARGEST_REST`].
const USUAL_DIMENSIONS: usize = 72;
/// Dimensions are added while those left out hold more than this share of the energy: a square pad of 16 electrodes needs 72, of 32
/// 168. With 72 of those 168, a quarter of the response of the large readings was missing.
const LARGEST_REST: f64 = 4e-6;

/// Solves the table of one pad.
#[derive(Clone, Debug)]
pub struct ResponseBuilder {
    responses: Responses,
    places: Places,
    orbits: Orbits,
    channels: usize,
    key: String,
}

/// Where responses come from.
#[derive(Clone, Debug)]
enum Responses {
    /// Solved.
    Exact(Box<Scatterer>),
    /// Those of the drawing's table, changed to first order.
    Derived(Box<DerivedResponses>),
    /// Learned from presses.
    Learned(Box<LearnedResponses>),
}

impl Responses {
    /// How they grow with strength.
    fn law(&self) -> StrengthLaw {
        match self {
            Self::Exact(_) | Self::Derived(_) => StrengthLaw::Rise,
            Self::Learned(_) => StrengthLaw::Strength,
        }
    }

    /// Their first-order part; none of learned ones.
    fn linear(&self) -> Option<&LinearResponses> {
        match self {
            Self::Exact(scatterer) => Some(scatterer.linear()),
            Self::Derived(derived) => Some(derived.linear()),
            Self::Learned(_) => None,
        }
    }
}

/// What a table depends on beside its pad, for its key: after a change of one of these, no table solved before is read.
fn solver_constants() -> String {
    format!(
        "{STRENGTHS:?} {LEAST_SHARE} {USUAL_DIMENSIONS} {LARGEST_REST} {HALF_RISE} {MIDDLE_RISE} {:?} {:?} {STEP_LOG2} {:?}",
        places::CONSTANTS,
        scatter::CONSTANTS,
        stretch::CONSTANTS,
    )
}

/// One row of places, solved; the others follow by symmetry.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseRow {
    /// Solved places x samples x channels: responses divided by area and strength.
    scaled: Vec<f32>,
    /// What longer fingers add in the row of this number of the coarser grid of `stretch.rs`: places x axes, each the changes of all
    /// channels. Empty if there is no such row, and of learned pads.
    stretched: Vec<Vec<f64>>,
}

impl ResponseBuilder {
    /// Prepares a pad.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    pub fn new(pad: &Pad) -> Result<Self, SetupError> {
        let responses = match &pad.learned {
            Some(maps) => Responses::Learned(Box::new(LearnedResponses::new(pad, maps))),
            None => Responses::Exact(Box::new(Scatterer::new(pad)?)),
        };
        Ok(Self::with_responses(pad, responses))
    }

    /// Prepares a pad that differs a little from its drawing, whose table is given: a tenth of the work.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    pub fn from_drawing(pad: &Pad, table: Arc<ResponseTable>) -> Result<Self, SetupError> {
        let responses = Responses::Derived(Box::new(DerivedResponses::new(pad, table)?));
        Ok(Self::with_responses(pad, responses))
    }

    fn with_responses(pad: &Pad, responses: Responses) -> Self {
        let places = Places::new(pad.outline.size_mm());
        Self {
            responses,
            orbits: Orbits::new(pad, &places),
            places,
            channels: pad.channels(),
            key: Self::key(pad),
        }
    }

    /// The key of a pad's table: equal for equal pads and the same version of the solver.
    #[must_use]
    pub fn key(pad: &Pad) -> String {
        let Pad {
            outline,
            conductor,
            electrodes,
            protocol,
            ..
        } = pad;
        let key = format!(
            "{VERSION} {} {outline:?} {conductor:?} {electrodes:?} {:?} {:?} {:?} {protocol:?}",
            solver_constants(),
            pad.thickness_mm,
            pad.background_s_per_m,
            pad.contact_impedance_ohm_m2,
        );
        let key = if pad.deviations.is_none() {
            key
        } else {
            format!("{key} {:?}", pad.deviations)
        };
        match &pad.learned {
            None => key,
            Some(maps) => format!("{key} {maps:?}"),
        }
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.places.rows
    }

    /// Solves one row of places.
    #[must_use]
    pub fn solve_row(&self, row: usize) -> ResponseRow {
        let rise = |strength: &f64| HALF_RISE * strength / (1.0 - strength);
        let rises: Vec<f64> = STRENGTHS[1..].iter().map(rise).collect();
        let columns = self.places.columns;
        let mut scaled = Vec::new();
        for place in row * columns..(row + 1) * columns {
            if !self.orbits.is_solved(place) {
                continue;
            }
            let centre_mm = self.places.at_mm(place);
            let radii_mm = self.places.radii_mm();
            for (radius, radius_mm) in radii_mm.iter().enumerate().skip(1).take(SOLVED) {
                let scatterer = match &self.responses {
                    Responses::Exact(scatterer) => scatterer,
                    Responses::Derived(derived) => {
                        scaled.extend(derived.samples(place, radius, &STRENGTHS));
                        continue;
                    }
                    Responses::Learned(learned) => {
                        scaled.extend(learned.samples(centre_mm));
                        continue;
                    }
                };
                let changes = scatterer.changes(centre_mm, *radius_mm, &rises);
                let per_mm2 = 1.0 / (radius_mm * radius_mm);
                for (sign, responses) in [1.0, -1.0].into_iter().zip(&changes.by_sign) {
                    let faintest = (&changes.per_rise, sign * HALF_RISE * per_mm2);
                    let solved = responses.iter().zip(&STRENGTHS[1..]);
                    let solved = solved.map(|(response, strength)| (response, per_mm2 / strength));
                    for (response, scale) in std::iter::once(faintest).chain(solved) {
                        scaled.extend(response.iter().map(|change| (change * scale) as f32));
                    }
                }
            }
        }
        let stretched = match self.responses.linear() {
            Some(linear) if row < Stretches::rows(&self.places) => {
                Stretches::solve_row(linear, &self.places, row)
            }
            _ => Vec::new(),
        };
        ResponseRow { scaled, stretched }
    }

    /// Assembles the table from all rows, in order.
    ///
    /// # Panics
    /// If a row is missing.
    #[must_use]
    pub fn finish(self, rows: &[ResponseRow]) -> ResponseTable {
        assert_eq!(rows.len(), self.places.rows, "all rows");
        let basis = self.basis(rows);
        let rank = basis.ncols();
        let law = self.responses.law();
        let powers = powers_through_strengths(law);
        // Rise and fall, each solved places x radii x powers x rank.
        let mut terms: [Vec<f32>; SIGNS] = Default::default();
        for samples in rows
            .iter()
            .flat_map(|row| row.scaled.chunks_exact(SAMPLES * self.channels))
        {
            let responses = Mat::from_fn(self.channels, SAMPLES, |channel, sample| {
                f64::from(samples[sample * self.channels + channel])
            });
            let coordinates = basis.transpose() * &responses;
            for (sign, terms) in terms.iter_mut().enumerate() {
                extend_by_radii(terms, |radius| {
                    let first = (radius * SIGNS + sign) * POWERS;
                    coordinates.get(.., first..first + POWERS) * &powers
                });
            }
        }
        let stretches = self.responses.linear().map(|_| {
            let changes = rows.iter().flat_map(|row| &row.stretched);
            let projected = changes.flat_map(|changes| {
                let along = |dimension: usize| {
                    let column = basis.col(dimension).iter();
                    column.zip(changes).map(|(a, b)| a * b).sum::<f64>() as f32
                };
                (0..rank).map(along).collect::<Vec<f32>>()
            });
            Stretches::new(projected.collect(), &self.places, rank)
        });
        let basis: Vec<f32> = (0..rank)
            .flat_map(|dimension| basis.col(dimension).iter().map(|value| *value as f32))
            .collect();
        let mut solved = terms.concat();
        quantized::round(&mut solved, &self.places, rank);
        ResponseTable {
            key: self.key,
            channels: self.channels,
            rank,
            places: self.places,
            law,
            terms: Terms::new(solved, rank, self.orbits, &basis),
            basis,
            stretches,
        }
    }

    /// Principal directions of all responses, orthonormal, strongest first: channels x dimensions.
    fn basis(&self, rows: &[ResponseRow]) -> Mat<f64> {
        let mut energy = Mat::<f64>::zeros(self.channels, self.channels);
        let samples = rows
            .iter()
            .flat_map(|row| row.scaled.chunks_exact(self.channels));
        // Neighbouring samples are alike: one in five is enough.
        let chosen: Vec<&[f32]> = samples.step_by(5).collect();
        for batch in chosen.chunks(256) {
            // Normalised: otherwise touches near electrodes, the strongest, would dominate.
            let energy_of = |sample: &[f32]| {
                let square: f32 = sample.iter().map(|change| change * change).sum();
                f64::from(square).max(f64::MIN_POSITIVE)
            };
            let lengths: Vec<f64> = batch
                .iter()
                .map(|sample| libm::sqrt(energy_of(sample)))
                .collect();
            let matrix = Mat::from_fn(self.channels, batch.len(), |channel, sample| {
                f64::from(batch[sample][channel]) / lengths[sample]
            });
            energy += &matrix * matrix.transpose();
        }
        // The places that follow by symmetry count, too.
        let solved = std::mem::replace(&mut energy, Mat::zeros(self.channels, self.channels));
        for readings in self.orbits.reading_orders() {
            energy += Mat::from_fn(self.channels, self.channels, |row, column| {
                solved[(readings[row], readings[column])]
            });
        }
        let total: f64 = (0..self.channels).map(|i| energy[(i, i)]).sum();
        let Ok(eigen) = SelfAdjointEigen::new(energy.as_ref(), Side::Lower) else {
            return Mat::identity(self.channels, self.channels.next_multiple_of(LANES));
        };
        let values = eigen.S().column_vector();
        // Eigenvalues ascend: the strongest come last.
        let strongest_first = (0..self.channels).rev().map(|index| values[index]);
        let rank = needed_dimensions(strongest_first, total).next_multiple_of(LANES);
        // A protocol of few channels spans few dimensions: the rest of the rank is zero.
        Mat::from_fn(self.channels, rank, |channel, dimension| {
            match self.channels.checked_sub(dimension + 1) {
                Some(column) => eigen.U()[(channel, column)],
                None => 0.0,
            }
        })
    }
}

/// How many dimensions a table keeps, given the energy in each, strongest first, and their sum.
fn needed_dimensions(energies: impl Iterator<Item = f64>, total: f64) -> usize {
    let mut rest = total;
    energies
        .enumerate()
        .take_while(|(before, energy)| {
            let is_needed = *before < USUAL_DIMENSIONS || rest > LARGEST_REST * total;
            rest -= energy;
            is_needed && *energy > LEAST_SHARE * total
        })
        .count()
}

/// Appends the terms of all radii at a place: those solved (rank x powers each) and the two beyond them.
fn extend_by_radii(terms: &mut Vec<f32>, solved: impl Fn(usize) -> Mat<f64>) {
    let solved: Vec<Mat<f64>> = (0..SOLVED).map(solved).collect();
    let before = extrapolated(&solved[0], &solved[1], &solved[2]);
    let after = extrapolated(
        &solved[SOLVED - 1],
        &solved[SOLVED - 2],
        &solved[SOLVED - 3],
    );
    for radius in std::iter::once(&before).chain(&solved).chain([&after]) {
        for power in 0..POWERS {
            terms.extend(radius.col(power).iter().map(|value| *value as f32));
        }
    }
}

/// Extrapolates three evenly spaced values, nearest first, along the parabola through them.
fn extrapolated(first: &Mat<f64>, second: &Mat<f64>, third: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(first.nrows(), first.ncols(), |i, j| {
        3.0 * (first[(i, j)] - second[(i, j)]) + third[(i, j)]
    })
}

/// Samples x powers: the terms that give the samples, which are divided by their strength.
fn powers_through_strengths(law: StrengthLaw) -> Mat<f64> {
    let factors = STRENGTHS.map(|strength| law.factors_per_strength(strength));
    let design = Mat::from_fn(POWERS, POWERS, |power, sample| factors[sample][power]);
    design
        .partial_piv_lu()
        .solve(Mat::<f64>::identity(POWERS, POWERS))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eit::response::strength_from_rise;

    /// How many dimensions are kept if each holds `share` of the energy of the one before.
    fn needed(share: f64) -> usize {
        let energies: Vec<f64> = (0..464).map(|i| libm::pow(share, f64::from(i))).collect();
        needed_dimensions(energies.iter().copied(), energies.iter().sum())
    }

    #[test]
    fn tables_of_many_electrodes_keep_more_dimensions() {
        assert_eq!(needed(0.5), 29, "weaker ones are below 90 dB");
        assert_eq!(needed(0.8), USUAL_DIMENSIONS);
        assert_eq!(
            needed(0.9),
            118,
            "0.9^118 is the first below the largest rest"
        );
    }

    #[test]
    fn three_samples_describe_how_spots_of_every_shape_saturate() {
        let powers = powers_through_strengths(StrengthLaw::Rise);
        // A spot changes a reading by rise / (1 + b rise), b between 0 and 1.
        for b in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let per_strength = |strength: f64| {
                let rise_per_strength = HALF_RISE / (1.0 - strength);
                rise_per_strength / (1.0 + b * rise_per_strength * strength)
            };
            let samples = Mat::from_fn(1, POWERS, |_, sample| per_strength(STRENGTHS[sample]));
            let terms = samples * &powers;
            for rise in [0.02, 0.1, 0.3, 0.7, 1.0, 1.5, 2.0, 3.0, 4.5] {
                let strength = strength_from_rise(rise);
                let factors = StrengthLaw::Rise.factors(strength);
                let of_terms = factors.iter().enumerate();
                let sum: f64 = of_terms
                    .map(|(k, [factor, _])| factor * terms[(0, k)])
                    .sum();
                let off = sum / (strength * per_strength(strength)) - 1.0;
                assert!(off.abs() < 0.05, "b {b}, rise {rise}: {off}");
            }
        }
    }
}
