//! Symmetries of a pad: the turns and mirrorings that map it onto itself.
//!
//! A touch at the image of a place changes the readings as a touch at the place does, in another order. So the response table
//! solves one place of each set of images, an eighth of all on a square pad.

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

/// The place that another one follows from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Origin {
    /// The least of the images of the place, which is solved.
    place: usize,
    /// Its number among the solved places.
    pub(super) solved: usize,
    /// The symmetry that maps it to the place.
    pub(super) symmetry: usize,
}

/// Which places of a table follow from which.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Orbits {
    symmetries: Vec<Symmetry>,
    /// For each place.
    origins: Vec<Origin>,
    /// Number of solved places.
    solved: usize,
}

impl Orbits {
    /// The orbits of a grid of places on a pad.
    pub(super) fn new(pad: &Pad, places: &Places) -> Self {
        let conductor = Conductor::sampled(pad);
        let is_as_drawn = pad.deviations.is_none() && pad.learned.is_none();
        let symmetries: Vec<Symmetry> = TURNS
            .iter()
            .filter(|turn| **turn == TURNS[0] || is_as_drawn)
            .filter_map(|turn| Symmetry::new(*turn, pad, &conductor))
            .filter(|symmetry| {
                (0..places.len()).all(|index| symmetry.image(index, pad, places).is_some())
            })
            .collect();
        let mut origins: Vec<Option<Origin>> = vec![None; places.len()];
        let mut solved = 0;
        for least in 0..places.len() {
            if origins[least].is_some() {
                continue;
            }
            let origin = |symmetry| Origin {
                place: least,
                solved,
                symmetry,
            };
            origins[least] = Some(origin(0));
            for (number, symmetry) in symmetries.iter().enumerate() {
                if let Some(image) = symmetry.image(least, pad, places).filter(|at| *at > least) {
                    origins[image] = Some(origin(number));
                }
            }
            solved += 1;
        }
        Self {
            symmetries,
            origins: origins.into_iter().flatten().collect(),
            solved,
        }
    }

    /// No place follows from another: tables of the first version.
    pub(super) fn none(places: &Places, channels: usize) -> Self {
        Self {
            symmetries: vec![Symmetry {
                turn: TURNS[0],
                readings: (0..channels).collect(),
            }],
            origins: (0..places.len())
                .map(|place| Origin {
                    place,
                    solved: place,
                    symmetry: 0,
                })
                .collect(),
            solved: places.len(),
        }
    }

    /// Number of solved places.
    pub(super) fn solved(&self) -> usize {
        self.solved
    }

    /// Number of places.
    pub(super) fn len(&self) -> usize {
        self.origins.len()
    }

    /// What each symmetry does to coordinates in a basis (rows of readings): columns of a matrix, rank x rank.
    pub(super) fn turned_bases(&self, basis: &[f32]) -> Vec<Vec<f32>> {
        let channels = self.symmetries[0].readings.len();
        let rank = basis.len() / channels;
        let by_channel: Vec<f64> = (0..channels * rank)
            .map(|index| f64::from(basis[index % rank * channels + index / rank]))
            .collect();
        let symmetries = self.symmetries.iter();
        symmetries
            .map(|symmetry| symmetry.turned_basis(basis, &by_channel))
            .collect()
    }

    /// What a place follows from.
    pub(super) fn origin(&self, place: usize) -> Origin {
        self.origins[place]
    }

    /// Whether a place is solved.
    pub(super) fn is_solved(&self, place: usize) -> bool {
        self.origins[place].place == place
    }

    /// The order of the readings under each symmetry.
    pub(super) fn reading_orders(&self) -> impl Iterator<Item = &[usize]> {
        self.symmetries
            .iter()
            .map(|symmetry| symmetry.readings.as_slice())
    }
}

impl Symmetry {
    /// The symmetry of a turn; `None` if it does not map the pad onto itself.
    fn new(turn: Turn, pad: &Pad, conductor: &Conductor) -> Option<Self> {
        let [width, height] = pad.outline.size_mm();
        let same_mm = SAME * width.max(height);
        let swaps_sides = turn[0][0] == 0.0;
        if swaps_sides && (width - height).abs() > same_mm {
            return None;
        }
        let is_conductor_kept = conductor.is_kept_by(turn);
        let numbering = is_conductor_kept.then(|| renumbering(turn, pad, same_mm))??;
        let readings = Renumbered::new(&pad.protocol, numbering)?
            .board_indices()
            .collect();
        Some(Self { turn, readings })
    }

    /// What the symmetry does to coordinates in a basis: columns of a matrix, rank x rank. `by_channel` is the basis by channels:
    /// channels x rank. The order of the sums is fixed; several are formed at a time.
    fn turned_basis(&self, basis: &[f32], by_channel: &[f64]) -> Vec<f32> {
        let rank = by_channel.len() / self.readings.len();
        let mut columns = Vec::with_capacity(rank * rank);
        let mut sums = vec![0.0; rank];
        for from in basis.chunks_exact(self.readings.len()) {
            sums.fill(0.0);
            for (reading, values) in self.readings.iter().zip(by_channel.chunks_exact(rank)) {
                let factor = f64::from(from[*reading]);
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += value * factor;
                }
            }
            columns.extend(sums.iter().map(|sum| *sum as f32));
        }
        columns
    }

    /// The place to which a place is mapped, if it is one of the grid.
    fn image(&self, index: usize, pad: &Pad, places: &Places) -> Option<usize> {
        places.index_at(turned(self.turn, places.at_mm(index), pad))
    }
}

/// Where a pad has conductor: [`SAMPLES`] x [`SAMPLES`] points, evenly spaced within its box.
struct Conductor(Vec<bool>);

impl Conductor {
    fn sampled(pad: &Pad) -> Self {
        let [width, height] = pad.outline.size_mm();
        let at = |sample: usize, side: f64| (sample as f64 + 0.5) / SAMPLES as f64 * side;
        let points = (0..SAMPLES * SAMPLES)
            .map(|index| [at(index / SAMPLES, width), at(index % SAMPLES, height)]);
        Self(points.map(|point| pad.conducts_at(point)).collect())
    }

    /// Whether a turn about the centre, which maps the points onto each other, maps conductor to conductor.
    fn is_kept_by(&self, turn: Turn) -> bool {
        // Twice the distance from the centre, in samples: a whole number.
        let middle = SAMPLES as f64 - 1.0;
        (0..SAMPLES * SAMPLES).all(|index| {
            let off = [index / SAMPLES, index % SAMPLES].map(|at| 2.0 * at as f64 - middle);
            let [i, j] = turn.map(|row| (row[0] * off[0] + row[1] * off[1] + middle) / 2.0);
            self.0[index] == self.0[i as usize * SAMPLES + j as usize]
        })
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
            assert!(orbits.is_solved(orbits.origins[place].place));
        }
    }
}
