//! Symmetries of a pad: the turns and mirrorings that map it onto itself.
//!
//! A touch at the image of a place changes the readings as a touch at the place does, in another order. So the response table
//! solves one place of each set of images, an eighth of all on a square pad.

use pulp::{Arch, NullaryFnOnce};

use super::LANES;
use super::places::Places;
use crate::pad::{Direction, Numbering, Pad, Renumbered};
use crate::types::PointMm;

/// Places and widths agree within this share of the pad's longer side.
const SAME: f64 = 1e-6;
/// Points along each side at which the conductor is compared.
const SAMPLES: usize = 211;

/// A map of the plane that keeps the centre of the pad: rows of a matrix of 0, 1 and -1.
type Turn = [[f64; 2]; 2];

/// The quarter turns, and the same after a mirroring. The first changes nothing.
const TURNS: [Turn; 8] = [
    [[1.0, 0.0], [0.0, 1.0]],
    [[0.0, -1.0], [1.0, 0.0]],
    [[-1.0, 0.0], [0.0, -1.0]],
    [[0.0, 1.0], [-1.0, 0.0]],
    [[-1.0, 0.0], [0.0, 1.0]],
    [[1.0, 0.0], [0.0, -1.0]],
    [[0.0, 1.0], [1.0, 0.0]],
    [[0.0, -1.0], [-1.0, 0.0]],
];

/// One symmetry of a pad.
#[derive(Clone, Debug, PartialEq)]
struct Symmetry {
    turn: Turn,
    /// For each reading with the touch at the image of a place, the reading with the touch at the place.
    readings: Vec<usize>,
}

/// Which places of a table follow from which.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Orbits {
    symmetries: Vec<Symmetry>,
    /// For each place the least of its images, and the symmetry that maps that one to it.
    origins: Vec<(usize, usize)>,
}

impl Orbits {
    /// The orbits of a grid of places on a pad.
    pub(super) fn new(pad: &Pad, places: &Places) -> Self {
        let symmetries: Vec<Symmetry> = TURNS
            .iter()
            .filter(|turn| **turn == TURNS[0] || pad.deviations.is_none())
            .filter_map(|turn| Symmetry::new(*turn, pad))
            .filter(|symmetry| {
                (0..places.len()).all(|index| symmetry.image(index, pad, places).is_some())
            })
            .collect();
        let mut origins: Vec<(usize, usize)> = (0..places.len()).map(|index| (index, 0)).collect();
        for least in 0..places.len() {
            if origins[least].0 != least {
                continue;
            }
            for (number, symmetry) in symmetries.iter().enumerate() {
                if let Some(image) = symmetry.image(least, pad, places).filter(|at| *at > least) {
                    origins[image] = (least, number);
                }
            }
        }
        Self {
            symmetries,
            origins,
        }
    }

    /// No place follows from another: tables of the first version.
    pub(super) fn none(places: &Places, channels: usize) -> Self {
        Self {
            symmetries: vec![Symmetry {
                turn: TURNS[0],
                readings: (0..channels).collect(),
            }],
            origins: (0..places.len()).map(|place| (place, 0)).collect(),
        }
    }

    /// Number of solved places.
    pub(super) fn solved(&self) -> usize {
        (0..self.origins.len())
            .filter(|place| self.is_solved(*place))
            .count()
    }

    /// The vectors at all places from those at the solved ones, in the order of the places; `per_place` vectors of the basis's
    /// rank each. `basis` holds rows of readings. Of `solved`, and so of the result, several such lists may follow each other.
    ///
    /// The order of the sums is fixed: the same bits on every machine.
    ///
    /// # Panics
    /// If the rank is no multiple of [`LANES`].
    pub(super) fn expand(&self, solved: &[f32], per_place: usize, basis: &[f32]) -> Vec<f32> {
        let turns: Vec<Vec<f32>> = self
            .symmetries
            .iter()
            .map(|symmetry| symmetry.turned_basis(basis))
            .collect();
        let channels = self.symmetries[0].readings.len();
        let rank = basis.len() / channels;
        let stride = per_place * rank;
        let mut end = 0;
        let first_of: Vec<usize> = (0..self.origins.len())
            .map(|place| {
                let first = end;
                end += if self.is_solved(place) { stride } else { 0 };
                first
            })
            .collect();
        let lists = solved.len() / end.max(1);
        let mut all = vec![0.0f32; lists * self.origins.len() * stride];
        let arch = Arch::new();
        for (index, into) in all.chunks_exact_mut(stride).enumerate() {
            let (list, place) = (index / self.origins.len(), index % self.origins.len());
            let (origin, symmetry) = self.origins[place];
            let vectors = &solved[list * end + first_of[origin]..][..stride];
            if origin == place {
                into.copy_from_slice(vectors);
            } else {
                let columns = &turns[symmetry];
                arch.dispatch(Turning {
                    vectors,
                    columns,
                    rank,
                    turned: into,
                });
            }
        }
        all
    }

    /// Whether a place is solved.
    pub(super) fn is_solved(&self, place: usize) -> bool {
        self.origins[place].0 == place
    }

    /// The order of the readings under each symmetry.
    pub(super) fn reading_orders(&self) -> impl Iterator<Item = &[usize]> {
        self.symmetries
            .iter()
            .map(|symmetry| symmetry.readings.as_slice())
    }
}

/// Vectors times what a symmetry does to coordinates, dispatched by processor: only code inlined here is compiled for each. A few sums of
/// a few vectors are kept in registers, since every start of a game does this for each place.
struct Turning<'a> {
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
        const VECTORS: usize = 4;
        let block = VECTORS * self.rank;
        for (vectors, turned) in self
            .vectors
            .chunks(block)
            .zip(self.turned.chunks_mut(block))
        {
            for first in (0..self.rank).step_by(LANES) {
                let mut sums = [[0.0f32; LANES]; VECTORS];
                for (index, column) in self.columns.chunks_exact(self.rank).enumerate() {
                    for (sums, vector) in sums.iter_mut().zip(vectors.chunks_exact(self.rank)) {
                        for (sum, entry) in sums.iter_mut().zip(&column[first..first + LANES]) {
                            *sum += vector[index] * entry;
                        }
                    }
                }
                for (turned, sums) in turned.chunks_exact_mut(self.rank).zip(&sums) {
                    turned[first..first + LANES].copy_from_slice(sums);
                }
            }
        }
    }
}

impl Symmetry {
    /// The symmetry of a turn; `None` if it does not map the pad onto itself.
    fn new(turn: Turn, pad: &Pad) -> Option<Self> {
        let [width, height] = pad.outline.size_mm();
        let same_mm = SAME * width.max(height);
        let swaps_sides = turn[0][0] == 0.0;
        if swaps_sides && (width - height).abs() > same_mm {
            return None;
        }
        let point = |i: usize, j: usize| {
            [(i, width), (j, height)].map(|(k, side)| (k as f64 + 0.5) / SAMPLES as f64 * side)
        };
        let is_conductor_kept = (0..SAMPLES * SAMPLES).all(|index| {
            let point = point(index / SAMPLES, index % SAMPLES);
            pad.conducts_at(point) == pad.conducts_at(turned(turn, point, pad))
        });
        let numbering = is_conductor_kept.then(|| renumbering(turn, pad, same_mm))??;
        let readings = Renumbered::new(&pad.protocol, numbering)?
            .board_indices()
            .collect();
        Some(Self { turn, readings })
    }

    /// What the symmetry does to coordinates in a basis: columns of a matrix, rank x rank.
    fn turned_basis(&self, basis: &[f32]) -> Vec<f32> {
        let channels = self.readings.len();
        let rows = || basis.chunks_exact(channels);
        let mut columns = Vec::with_capacity(rows().len() * rows().len());
        for from in rows() {
            columns.extend(rows().map(|to| {
                let sum: f64 = to
                    .iter()
                    .zip(&self.readings)
                    .map(|(value, reading)| f64::from(*value) * f64::from(from[*reading]))
                    .sum();
                sum as f32
            }));
        }
        columns
    }

    /// The place to which a place is mapped, if it is one of the grid.
    fn image(&self, index: usize, pad: &Pad, places: &Places) -> Option<usize> {
        places.index_at(turned(self.turn, places.at_mm(index), pad))
    }
}

/// The image of a point.
fn turned(turn: Turn, point: PointMm, pad: &Pad) -> PointMm {
    let centre = pad.outline.size_mm().map(|side| side / 2.0);
    let off = [point[0] - centre[0], point[1] - centre[1]];
    [0, 1].map(|k| centre[k] + turn[k][0] * off[0] + turn[k][1] * off[1])
}

/// The electrode onto which a turn maps each electrode, as a numbering; `None` if it maps one onto none.
fn renumbering(turn: Turn, pad: &Pad, same_mm: f64) -> Option<Numbering> {
    let count = pad.electrodes.len();
    let centres: Vec<PointMm> = pad
        .electrodes
        .iter()
        .map(|electrode| electrode.centre_mm(&pad.outline))
        .collect();
    let image_of = |electrode: usize| {
        let [x, y] = turned(turn, centres[electrode], pad);
        (0..count)
            .find(|other| libm::hypot(centres[*other][0] - x, centres[*other][1] - y) < same_mm)
    };
    let is_mirrored = turn[0][0] * turn[1][1] - turn[0][1] * turn[1][0] < 0.0;
    let numbering = Numbering {
        first: image_of(0)?,
        direction: if is_mirrored {
            Direction::Clockwise
        } else {
            Direction::CounterClockwise
        },
    };
    let is_right = (0..count).all(|electrode| {
        let image = numbering.place(electrode, count);
        let widths = [electrode, image].map(|index| pad.electrodes[index].width_mm);
        image_of(electrode) == Some(image) && (widths[0] - widths[1]).abs() < same_mm
    });
    is_right.then_some(numbering)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, shipped_pad};

    fn pad(replace: [&str; 2]) -> Pad {
        let text = shipped_pad(DEFAULT_PAD).expect("shipped").toml;
        assert!(text.contains(replace[0]), "{}", replace[0]);
        Pad::from_toml("p", &text.replacen(replace[0], replace[1], 1)).expect("valid")
    }

    fn orbits(pad: &Pad) -> Orbits {
        Orbits::new(pad, &Places::new(pad.outline.size_mm()))
    }

    #[test]
    fn a_square_pad_has_eight_symmetries() {
        let pad = pad(["", ""]);
        let orbits = orbits(&pad);
        assert_eq!(orbits.symmetries.len(), 8);
        let places = Places::new(pad.outline.size_mm());
        let solved = (0..places.len()).filter(|place| orbits.is_solved(*place));
        assert!(solved.count() < places.len() / 6);
        for place in 0..places.len() {
            assert!(orbits.is_solved(orbits.origins[place].0));
        }
    }
}
