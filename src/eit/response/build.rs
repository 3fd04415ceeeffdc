//! Solves a pad's table of responses, row by row of its places.
//!
//! Rows depend on nothing but the pad, so whoever builds the table may share them among threads and show how far it is;
//! the table is the same, bit for bit.

use faer::linalg::solvers::SelfAdjointEigen;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::{HALF_RISE, LANES, POWERS, Places, RADII, ResponseTable, Scatterer};
use crate::eit::SetupError;
use crate::pad::Pad;

/// Counted up whenever tables come out otherwise for the same pad.
const VERSION: u32 = 1;
/// Strengths at which responses are solved: rises of 0.4, 1.4 and 4.5.
const STRENGTHS: [f64; POWERS] = [0.21, 0.48, 0.75];
/// Radii that are solved: all but the outermost, which continue them.
const SOLVED: usize = RADII - 2;
/// Samples of one place.
const SAMPLES: usize = SOLVED * POWERS;
/// Directions of the responses whose share of their energy is below this are left out: 90 dB under the strongest.
const LEAST_SHARE: f64 = 1e-9;
/// ... and never are there more than these.
const MOST_DIMENSIONS: usize = 64;

/// Solves one table.
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
    /// Places by samples by channels: the response over area and strength.
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

    /// Names a pad's table: the same for the same pad and the same way of solving it.
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

    /// Puts the rows, in their order, together.
    ///
    /// # Panics
    /// If a row is missing.
    #[must_use]
    pub fn finish(self, rows: &[ResponseRow]) -> ResponseTable {
        assert_eq!(rows.len(), self.places.rows, "every row once");
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
            // Rank by powers, one matrix a radius.
            let solved: Vec<Mat<f64>> = (0..SOLVED)
                .map(|radius| coordinates.get(.., radius * POWERS..(radius + 1) * POWERS) * &powers)
                .collect();
            let before = continued(&solved[0], &solved[1], &solved[2]);
            let after = continued(
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

    /// Directions that hold all but nothing of every response, orthonormal, strongest first: channels by dimensions.
    fn basis(&self, rows: &[ResponseRow]) -> Mat<f64> {
        let mut energy = Mat::<f64>::zeros(self.channels, self.channels);
        let samples = rows
            .iter()
            .flat_map(|row| row.scaled.chunks_exact(self.channels));
        // Neighbouring samples are alike: one of several will do.
        let chosen: Vec<&[f32]> = samples.step_by(5).collect();
        for batch in chosen.chunks(256) {
            // Each counts alike, or the touches near electrodes, which are strongest, would take all directions.
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
        // Ascending: the strongest stand last.
        let rank = (0..self.channels)
            .rev()
            .take(MOST_DIMENSIONS)
            .take_while(|index| values[*index] > LEAST_SHARE * total)
            .count()
            .next_multiple_of(LANES);
        // A protocol of few channels spans few directions: the rest of the rank is nothing.
        Mat::from_fn(self.channels, rank, |channel, dimension| {
            match self.channels.checked_sub(dimension + 1) {
                Some(column) => eigen.U()[(channel, column)],
                None => 0.0,
            }
        })
    }
}

/// The next of three evenly spaced values, nearest first, on the parabola through them.
fn continued(first: &Mat<f64>, second: &Mat<f64>, third: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(first.nrows(), first.ncols(), |i, j| {
        3.0 * (first[(i, j)] - second[(i, j)]) + third[(i, j)]
    })
}

/// Samples by powers: the polynomial of the strength that runs through the samples.
fn powers_through_strengths() -> Mat<f64> {
    let design = Mat::from_fn(POWERS, POWERS, |power, sample| {
        (0..power).fold(1.0, |product, _| product * STRENGTHS[sample])
    });
    design
        .partial_piv_lu()
        .solve(Mat::<f64>::identity(POWERS, POWERS))
}
