//! The terms of a table at each place: those solved, and the others, turned when they are first needed.
//!
//! A finger visits few places with few radii, and most players press with one sign. Turning all places of both signs at the start
//! would take 39 ms and 35 MB.
//!
//! Invariant: the order of the sums is fixed, so a place has the same bits on every machine and whenever it is turned.

use pulp::{Arch, NullaryFnOnce};

use super::LANES;
use super::once_slots::OnceSlots;
use super::places::RADII;
use super::symmetry::Orbits;

/// Terms of the polynomial in strength at each radius.
pub(super) const POWERS: usize = 3;
/// Vectors stored per place and sign.
pub(super) const TERMS: usize = RADII * POWERS;
/// Signs of a table: a rise, then a fall.
pub(super) const SIGNS: usize = 2;

/// Terms of all places: radii x powers of the strength x rank each.
#[derive(Clone, Debug)]
pub(super) struct Terms {
    /// Signs x solved places x radii x powers x rank.
    solved: Vec<f32>,
    /// Which places follow from which by symmetry.
    orbits: Orbits,
    /// What each symmetry does to coordinates: rank x rank, as columns.
    turns: Vec<Vec<f32>>,
    /// Signs x radii x places: places side by side, since most radii are never needed.
    turned: OnceSlots,
    /// Values per place and radius.
    stride: usize,
}

impl PartialEq for Terms {
    /// Which places were turned already makes no difference.
    fn eq(&self, other: &Self) -> bool {
        (&self.solved, &self.orbits) == (&other.solved, &other.orbits)
    }
}

impl Terms {
    /// The terms at all places from those at the solved ones (signs x solved places x radii x powers x rank), and the basis, rows
    /// of readings.
    ///
    /// # Panics
    /// If there are no terms for one sign or two, or the rank is not a multiple of [`LANES`].
    pub(super) fn new(solved: Vec<f32>, rank: usize, orbits: Orbits, basis: &[f32]) -> Self {
        assert_eq!(rank % LANES, 0);
        let stride = POWERS * rank;
        let of_sign = orbits.solved() * RADII * stride;
        let signs = solved.len() / of_sign.max(1);
        assert!((1..=SIGNS).contains(&signs) && solved.len() == signs * of_sign);
        let turned = OnceSlots::new(signs * RADII * orbits.len(), stride);
        Self {
            turns: orbits.turned_bases(basis),
            turned,
            solved,
            orbits,
            stride,
        }
    }

    /// Number of signs: one in tables of the first version.
    pub(super) fn signs(&self) -> usize {
        self.turned.len() / (self.orbits.len() * RADII)
    }

    /// The terms at the places that the others follow from.
    pub(super) fn solved(&self) -> &[f32] {
        &self.solved
    }

    /// The terms of a sign at a place for the radius with this index: powers x rank.
    pub(super) fn at(&self, sign: usize, place: usize, radius: usize) -> &[f32] {
        let origin = self.orbits.origin(place);
        let first = (sign * self.orbits.solved() + origin.solved) * RADII + radius;
        let vectors = &self.solved[first * self.stride..][..self.stride];
        if self.orbits.is_solved(place) {
            return vectors;
        }
        let slot = (sign * RADII + radius) * self.orbits.len() + place;
        self.turned.get_or_write(slot, |turned| {
            Arch::new().dispatch(Turning {
                vectors,
                columns: &self.turns[origin.symmetry],
                rank: self.stride / POWERS,
                turned,
            });
        })
    }
}

/// Vectors times what a symmetry does to coordinates, dispatched by processor: only code inlined here is compiled for each. The
/// sums of [`LANES`] dimensions of all vectors are kept in registers.
struct Turning<'a> {
    /// Powers x rank.
    vectors: &'a [f32],
    /// Rank x rank.
    columns: &'a [f32],
    rank: usize,
    turned: &'a mut [f32],
}

impl NullaryFnOnce for Turning<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for first in (0..self.rank).step_by(LANES) {
            let mut sums = [[0.0f32; LANES]; POWERS];
            for (index, column) in self.columns.chunks_exact(self.rank).enumerate() {
                for (sums, vector) in sums.iter_mut().zip(self.vectors.chunks_exact(self.rank)) {
                    for (sum, entry) in sums.iter_mut().zip(&column[first..first + LANES]) {
                        *sum += vector[index] * entry;
                    }
                }
            }
            for (turned, sums) in self.turned.chunks_exact_mut(self.rank).zip(&sums) {
                turned[first..first + LANES].copy_from_slice(sums);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eit::response::places::Places;
    use crate::pad::{DEFAULT_PAD, Pad, shipped_pad};

    #[test]
    fn a_place_that_follows_has_the_readings_of_its_origin_in_the_order_of_the_symmetry() {
        let text = shipped_pad(DEFAULT_PAD).expect("shipped").toml;
        let pad = Pad::from_toml("p", text).expect("sound");
        let orbits = Orbits::new(&pad, &Places::new(pad.outline.size_mm()));
        // Every reading is a dimension of its own, so nothing is lost in a turn.
        let channels = pad.channels();
        let mut identity = vec![0.0; channels * channels];
        for channel in 0..channels {
            identity[channel * channels + channel] = 1.0;
        }
        let size = orbits.solved() * TERMS * channels;
        let solved: Vec<f32> = (0..2 * size).map(|index| (index % 8191) as f32).collect();
        let terms = Terms::new(solved, channels, orbits.clone(), &identity);
        assert_eq!(terms.signs(), 2);
        let orders: Vec<&[usize]> = orbits.reading_orders().collect();
        for place in (0..orbits.len()).step_by(97) {
            let origin = orbits.origin(place);
            for sign in 0..2 {
                let first = sign * size + origin.solved * TERMS * channels;
                for (reading, order) in orders[origin.symmetry].iter().enumerate() {
                    for radius in [0, RADII - 1] {
                        let from = first + radius * POWERS * channels + order;
                        assert_eq!(
                            terms.at(sign, place, radius)[reading],
                            (from % 8191) as f32,
                            "{place} {reading}"
                        );
                    }
                }
            }
        }
    }
}
