//! The table itself: a basis, a grid of places, and coefficients at each place.
//!
//! All responses of a pad lie close to a subspace of few dimensions, so the table holds coordinates in an orthonormal
//! basis of it instead of one value per channel. Several touches superpose: from two radii apart, their interaction is
//! smaller than the model error.

use super::law::StrengthLaw;
use super::places::Places;
use super::stretch::{StretchResponse, Stretches};
use super::terms::{SIGNS, Terms};
use crate::eit::cholesky::add_scaled;
use crate::types::PointMm;

/// Responses of one pad.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseTable {
    /// Identifies the pad and the solver's version; see [`super::ResponseBuilder::key`].
    pub(super) key: String,
    pub(super) channels: usize,
    /// Dimensions of the subspace that the responses span.
    pub(super) rank: usize,
    /// Rank x channels, rows orthonormal: coordinates times the basis are relative changes.
    pub(super) basis: Vec<f32>,
    pub(super) places: Places,
    /// How responses grow with strength.
    pub(super) law: StrengthLaw,
    /// Of each sign at each place. Tables of the first version hold one sign, that of the pad.
    pub(super) terms: Terms,
    /// What longer fingers add; none in tables of older recordings and of pads that were learned.
    pub(super) stretches: Option<Stretches>,
}

/// A response and its derivatives, in the table's coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Response {
    /// The response.
    pub value: Vec<f32>,
    /// Derivatives by x, y (1/mm), log radius and strength.
    pub derivatives: [Vec<f32>; 4],
}

impl ResponseTable {
    /// Number of voltages in a frame.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Dimensions of the subspace that all responses span.
    #[must_use]
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// One row of the orthonormal basis: relative changes, one per channel.
    #[must_use]
    #[inline(always)]
    pub fn basis_row(&self, dimension: usize) -> &[f32] {
        &self.basis[dimension * self.channels..(dimension + 1) * self.channels]
    }

    /// Identifies the pad and the version of the solver.
    #[must_use]
    pub fn key(&self) -> &str {
        &self.key
    }

    /// Smallest and largest radius that the table covers, mm.
    #[must_use]
    pub fn radii_mm(&self) -> [f64; 2] {
        let radii = self.places.radii_mm();
        [radii[1], radii[radii.len() - 2]]
    }

    /// How far outside the pad's box a touch's centre may be, mm.
    #[must_use]
    pub fn reach_mm(&self) -> f64 {
        self.places.reach_mm()
    }

    /// Whether the table has responses of rising and falling touches; otherwise only those of the pad's sign.
    #[must_use]
    pub fn has_both_signs(&self) -> bool {
        self.terms.signs() == SIGNS
    }

    /// What a finger that is longer than wide adds at a place, for radius squared x strength of 1 mm2 along x and along the diagonal;
    /// false if the table does not know.
    pub fn respond_to_stretch(&self, centre_mm: PointMm, response: &mut StretchResponse) -> bool {
        match &self.stretches {
            Some(stretches) => stretches.respond(centre_mm, response),
            None => return false,
        }
        true
    }

    /// Converts coordinates to relative changes, one per channel.
    ///
    /// # Panics
    /// If `coordinates` does not have the table's rank, or `changes` not its number of channels.
    pub fn expand(&self, coordinates: &[f32], changes: &mut [f32]) {
        assert_eq!(
            (coordinates.len(), changes.len()),
            (self.rank, self.channels)
        );
        changes.fill(0.0);
        for (dimension, coordinate) in coordinates.iter().enumerate() {
            add_scaled(changes, self.basis_row(dimension), *coordinate);
        }
    }
}

#[cfg(test)]
use super::{
    places::RADII,
    symmetry::Orbits,
    terms::{POWERS, TERMS},
};

#[cfg(test)]
impl ResponseTable {
    /// A small smooth table, 60 x 40 mm, of twelve channels, eight of which respond.
    pub(crate) fn small() -> Self {
        let (channels, rank) = (12, super::LANES);
        let places = Places::new([60.0, 40.0]);
        let size = places.len() * TERMS * rank;
        let mut basis = vec![0.0; rank * channels];
        for dimension in 0..rank {
            basis[dimension * channels + dimension] = 1.0;
        }
        let terms = (0..SIGNS * size)
            .map(|index| {
                let sign = if index < size { 1.0 } else { -1.0 };
                let index = index % size;
                let place = places.at_mm(index / (TERMS * rank));
                let radius = (index / (POWERS * rank)) % RADII;
                let (power, dimension) = ((index / rank) % POWERS, index % rank);
                let phase = dimension as f64 + 0.3 * radius as f64;
                let wave = libm::sin(0.09 * place[0] + phase) + libm::cos(0.07 * place[1] - phase);
                (sign * wave * 1e-3 / (1.0 + power as f64)) as f32
            })
            .collect();
        let orbits = Orbits::none(&places, channels);
        Self {
            key: "small".to_owned(),
            channels,
            rank,
            terms: Terms::new(terms, rank, orbits, &basis),
            basis,
            places,
            law: StrengthLaw::Strength,
            stretches: None,
        }
    }
}
