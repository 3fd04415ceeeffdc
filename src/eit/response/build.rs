//! Solves a pad's response table, one row of places at a time.
//!
//! Rows are independent of each other: a caller may solve them on several threads and show progress; the table is the
//! same bit for bit.

use faer::linalg::solvers::SelfAdjointEigen;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::scatter::Scatterer;
use super::table::{HALF_RISE, LANES, POWERS, Places, RADII, ResponseTable};
use crate::eit::SetupError;
use crate::pad::Pad;

/// Part of the key; raised whenever the same pad gives another table.
const VERSION: u32 = 1;
/// Strengths at which responses are solved: rises of 0.4, 1.4 and 4.5.
const STRENGTHS: [f64; POWERS] = [0.21, 0.48, 0.75];
/// Radii that are solved; the outermost two are extrapolated.
const SOLVED: usize = RADII - 2;
/// Samples per place.
const SAMPLES: usize = SOLVED * POWERS;
/// Dimensions with less than this share of the responses' energy are left out: 90 dB below the total.
const LEAST_SHARE: f64 = 1e-9;
/// Largest rank of a table.
const MOST_DIMENSIONS: usize = 64;

/// Solves the table of one pad.
#[derive(Clone, Debug)]
pub struct ResponseBuilder {
    scatterer: Scatterer,
    places: Places,
    channels: usize,
    key: String,
}

/// One row of places, solved.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseRow {
    /// Places x samples x channels: responses divided by area and strength.
    scaled: Vec<f32>,
}

impl ResponseBuilder {
    /// Prepares a pad.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    pub fn new(pad: &Pad) -> Result<Self, SetupError> {
        Ok(Self {
            scatterer: Scatterer::new(pad)?,
            places: Places::new(pad.outline.size_mm()),
            channels: pad.channels(),
            key: Self::key(pad),
        })
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
        format!(
            "{VERSION} {outline:?} {conductor:?} {electrodes:?} {:?} {:?} {:?} {:?} {protocol:?}",
            pad.thickness_mm, pad.background_s_per_m, pad.contact_impedance_ohm_m2, pad.touch_sign,
        )
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.places.rows
    }

    /// Solves one row of places.
    #[must_use]
    pub fn solve_row(&self, row: usize) -> ResponseRow {
        let rises = STRENGTHS.map(|s| HALF_RISE * s / (1.0 - s));
        let mut scaled = Vec::with_capacity(self.places.columns * SAMPLES * self.channels);
        for column in 0..self.places.columns {
            let centre_mm = self.places.at_mm(row * self.places.columns + column);
            for radius_mm in &self.places.radii_mm()[1..=SOLVED] {
                let responses = self.scatterer.changes(centre_mm, *radius_mm, &rises);
                for (response, strength) in responses.iter().zip(STRENGTHS) {
                    let scale = 1.0 / (radius_mm * radius_mm * strength);
                    scaled.extend(response.iter().map(|change| (change * scale) as f32));
                }
            }
        }
        ResponseRow { scaled }
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
        let powers = powers_through_strengths();
        let mut terms = Vec::with_capacity(self.places.len() * RADII * POWERS * rank);
        for place in rows
            .iter()
            .flat_map(|row| row.scaled.chunks_exact(SAMPLES * self.channels))
        {
            let responses = Mat::from_fn(self.channels, SAMPLES, |channel, sample| {
                f64::from(place[sample * self.channels + channel])
            });
            let coordinates = basis.transpose() * &responses;
            // Rank x powers, one matrix per radius.
            let solved: Vec<Mat<f64>> = (0..SOLVED)
                .map(|radius| coordinates.get(.., radius * POWERS..(radius + 1) * POWERS) * &powers)
                .collect();
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
        ResponseTable {
            key: self.key,
            channels: self.channels,
            rank,
            basis: (0..rank)
                .flat_map(|dimension| basis.col(dimension).iter().map(|value| *value as f32))
                .collect(),
            places: self.places,
            terms,
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
            let length = |sample: &[f32]| {
                let square: f32 = sample.iter().map(|change| change * change).sum();
                f64::from(square).max(f64::MIN_POSITIVE)
            };
            let lengths: Vec<f64> = batch
                .iter()
                .map(|sample| libm::sqrt(length(sample)))
                .collect();
            let matrix = Mat::from_fn(self.channels, batch.len(), |channel, sample| {
                f64::from(batch[sample][channel]) / lengths[sample]
            });
            energy += &matrix * matrix.transpose();
        }
        let total: f64 = (0..self.channels).map(|i| energy[(i, i)]).sum();
        let Ok(eigen) = SelfAdjointEigen::new(energy.as_ref(), Side::Lower) else {
            return Mat::identity(self.channels, self.channels.next_multiple_of(LANES));
        };
        let values = eigen.S().column_vector();
        // Eigenvalues ascend: the strongest come last.
        let rank = (0..self.channels)
            .rev()
            .take(MOST_DIMENSIONS)
            .take_while(|index| values[*index] > LEAST_SHARE * total)
            .count()
            .next_multiple_of(LANES);
        // A protocol of few channels spans few dimensions: the rest of the rank is zero.
        Mat::from_fn(self.channels, rank, |channel, dimension| {
            match self.channels.checked_sub(dimension + 1) {
                Some(column) => eigen.U()[(channel, column)],
                None => 0.0,
            }
        })
    }
}

/// Extrapolates three evenly spaced values, nearest first, along the parabola through them.
fn extrapolated(first: &Mat<f64>, second: &Mat<f64>, third: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(first.nrows(), first.ncols(), |i, j| {
        3.0 * (first[(i, j)] - second[(i, j)]) + third[(i, j)]
    })
}

/// Samples x powers: coefficients of the polynomial in strength through the samples.
fn powers_through_strengths() -> Mat<f64> {
    let design = Mat::from_fn(POWERS, POWERS, |power, sample| {
        (0..power).fold(1.0, |product, _| product * STRENGTHS[sample])
    });
    design
        .partial_piv_lu()
        .solve(Mat::<f64>::identity(POWERS, POWERS))
}
