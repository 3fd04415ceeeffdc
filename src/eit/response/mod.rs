//! What a touch anywhere does to the voltages, non-linear and ready within microseconds.
//!
//! A table over places holds, for each, how the response varies with the touch's radius and strength. It is solved once a
//! pad ([`ResponseBuilder`]) and serves every frame: between places it is interpolated by cubics, so it has the
//! derivatives that a fit wants. All responses of a pad live in a space of few dimensions; the table holds their
//! coordinates there, not one value a channel.
//!
//! Several touches superpose: each saturates by itself, and what they do to each other is below the model's mismatch
//! from two radii on.
//!
//! Invariant: sums run in an order that this source fixes, so the same table gives the same bits everywhere, however wide the
//! vectors of the processor are.

mod build;
mod bytes;
mod scatter;

pub use build::{ResponseBuilder, ResponseRow};
pub use bytes::TableError;
pub use scatter::Scatterer;

use pulp::{Arch, NullaryFnOnce};

use crate::types::PointMm;

/// The strength that is half of saturation: strength = rise / (rise + this).
const HALF_RISE: f64 = 1.5;
/// Strongest touch that a table tells: a rise of 6.
pub const MOST_STRENGTH: f64 = 0.8;
/// Steps of the places along a pad's longer side: 2 mm on a 100 mm pad, where a lattice's channels still show.
const PLACES_ALONG: f64 = 50.0;
/// Radii of a table, each [`RADIUS_STEP`] times the one before. Closely spaced: a touch in a lattice's hole meets
/// conductor suddenly as it widens. The outermost two are no touches but neighbours for the cubics.
const RADII: usize = 7;
/// The smallest radius of a touch that is solved, as a share of the pad's longer side: 4.4 mm of 100 mm.
const LEAST_RADIUS_SHARE: f64 = 0.044;
const RADIUS_STEP: f64 = 1.22;
/// Terms of the polynomial in strength, at each radius.
const POWERS: usize = 3;
/// Dimensions that are summed at once; a table's rank is a multiple of it.
const LANES: usize = 8;

/// A touch as the table knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    /// Its middle, mm.
    pub centre_mm: PointMm,
    /// Natural logarithm of its radius in mm.
    pub log_radius: f64,
    /// Rise over (rise + 1.5): 0 for nothing, 1 for a perfect conductor.
    pub strength: f64,
}

impl Bump {
    /// Relative rise of conductivity in its middle.
    #[must_use]
    pub fn rise(&self) -> f64 {
        HALF_RISE * self.strength / (1.0 - self.strength)
    }
}

/// The strength of a relative rise.
#[must_use]
pub fn strength_of(rise: f64) -> f64 {
    rise / (rise + HALF_RISE)
}

/// Responses of one pad.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseTable {
    /// What pad it is of; see [`ResponseBuilder::key`].
    key: String,
    channels: usize,
    /// Dimensions of the space that the responses span.
    rank: usize,
    /// Rank by channels: orthonormal rows; a response's coordinates times it are its relative changes.
    basis: Vec<f32>,
    places: Places,
    /// Places by radii by powers of the strength by rank.
    terms: Vec<f32>,
}

/// The grid of places: one beyond the pad's box on each side, so that cubics have their neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Places {
    pitch_mm: f64,
    columns: usize,
    rows: usize,
}

impl Places {
    fn new([width, height]: [f64; 2]) -> Self {
        let pitch_mm = width.max(height) / PLACES_ALONG;
        let count = |side: f64| libm::ceil(side / pitch_mm - 1e-9) as usize + 3;
        Self {
            pitch_mm,
            columns: count(width),
            rows: count(height),
        }
    }

    fn len(&self) -> usize {
        self.columns * self.rows
    }

    fn at_mm(&self, index: usize) -> PointMm {
        let (row, column) = (index / self.columns, index % self.columns);
        [column, row].map(|step| (step as f64 - 1.0) * self.pitch_mm)
    }

    /// All radii of the table, mm.
    fn radii_mm(&self) -> [f64; RADII] {
        let mut radius_mm = LEAST_RADIUS_SHARE * PLACES_ALONG * self.pitch_mm / RADIUS_STEP;
        std::array::from_fn(|_| {
            let this = radius_mm;
            radius_mm *= RADIUS_STEP;
            this
        })
    }
}

/// A response and its derivatives, in the table's coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Response {
    /// The response.
    pub value: Vec<f32>,
    /// By x, y (1/mm), log radius and strength.
    pub derivatives: [Vec<f32>; 4],
}

impl ResponseTable {
    /// Number of voltages in a frame.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Dimensions of the space that all responses span.
    #[must_use]
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// One row of the basis: relative changes, one a channel; rows are orthonormal.
    #[must_use]
    pub fn basis_row(&self, dimension: usize) -> &[f32] {
        &self.basis[dimension * self.channels..(dimension + 1) * self.channels]
    }

    /// Which pad and which way of solving it the table is of.
    #[must_use]
    pub fn key(&self) -> &str {
        &self.key
    }

    /// Smallest and largest radius that the table tells, mm.
    #[must_use]
    pub fn radii_mm(&self) -> [f64; 2] {
        let radii = self.places.radii_mm();
        [radii[1], radii[RADII - 2]]
    }

    /// Adds up the relative changes that coordinates stand for.
    ///
    /// # Panics
    /// If a slice has not the table's rank or channels.
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

    /// The response of a touch and its derivatives. Outside the pad's box the nearest place counts, outside the table's
    /// radii the nearest radius.
    pub fn respond(&self, bump: &Bump, response: &mut Response) {
        Arch::new().dispatch(self.interpolation(bump, response));
    }

    fn interpolation<'a>(&'a self, bump: &Bump, response: &'a mut Response) -> Interpolation<'a> {
        let rank = self.rank;
        response.value.clear();
        response.value.resize(rank, 0.0);
        for derivative in &mut response.derivatives {
            derivative.clear();
            derivative.resize(rank, 0.0);
        }
        let [x, y] = bump.centre_mm;
        let pitch_mm = self.places.pitch_mm;
        Interpolation {
            table: self,
            size: Size::at(bump, &self.places),
            across: Cubic::at(x / pitch_mm + 1.0, self.places.columns).per(pitch_mm),
            up: Cubic::at(y / pitch_mm + 1.0, self.places.rows).per(pitch_mm),
            response,
        }
    }
}

/// What [`ResponseTable::respond`] sums, for the processor to be chosen: only what is inlined here is compiled for each.
struct Interpolation<'a> {
    table: &'a ResponseTable,
    size: Size,
    across: Cubic,
    up: Cubic,
    response: &'a mut Response,
}

impl NullaryFnOnce for Interpolation<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            table,
            size,
            across,
            up,
            response,
        } = self;
        let rank = table.rank;
        let radius_stride = POWERS * rank;
        let place_stride = RADII * radius_stride;
        // A few dimensions at a time: their sums stay in registers.
        for first in (0..rank).step_by(LANES) {
            let mut sums = [[0.0f32; LANES]; 5];
            for index in 0..16 {
                let (j, i) = (index / 4, index % 4);
                let place = (up.first + j) * table.places.columns + across.first + i;
                let start = place * place_stride + size.first_radius * radius_stride + first;
                let [value, by_radius, by_strength] =
                    sized(&table.terms[start..], rank, &size.terms);
                let weights = [
                    across.value[i] * up.value[j],
                    across.slope[i] * up.value[j],
                    across.value[i] * up.slope[j],
                ];
                for lane in 0..LANES {
                    sums[0][lane] += weights[0] * value[lane];
                    sums[1][lane] += weights[1] * value[lane];
                    sums[2][lane] += weights[2] * value[lane];
                    sums[3][lane] += weights[0] * by_radius[lane];
                    sums[4][lane] += weights[0] * by_strength[lane];
                }
            }
            let [value, derivatives @ ..] = sums;
            response.value[first..first + LANES].copy_from_slice(&value);
            for (derivative, sum) in response.derivatives.iter_mut().zip(derivatives) {
                derivative[first..first + LANES].copy_from_slice(&sum);
            }
        }
    }
}

/// A place's response and its derivatives by log radius and by strength, in a few dimensions.
#[inline(always)]
fn sized(terms: &[f32], rank: usize, factors: &[[f32; 3]; 4 * POWERS]) -> [[f32; LANES]; 3] {
    let mut sums = [[0.0f32; LANES]; 3];
    for (index, [value, by_radius, by_strength]) in factors.iter().enumerate() {
        let Some(row) = terms[index * rank..].first_chunk::<LANES>() else {
            break;
        };
        for lane in 0..LANES {
            sums[0][lane] += value * row[lane];
            sums[1][lane] += by_radius * row[lane];
            sums[2][lane] += by_strength * row[lane];
        }
    }
    sums
}

/// How a response varies with radius and strength: area x strength x a polynomial in the strength at each of four radii.
struct Size {
    first_radius: usize,
    /// Radii by powers: the term, its derivative by log radius, by strength.
    terms: [[f32; 3]; 4 * POWERS],
}

impl Size {
    fn at(bump: &Bump, places: &Places) -> Self {
        let step = libm::log(RADIUS_STEP);
        let least = libm::log(places.radii_mm()[0]);
        let radius = Cubic::at((bump.log_radius - least) / step, RADII).per(step);
        let log_least = least + step;
        let log_most = least + step * (RADII - 2) as f64;
        let area = libm::exp(2.0 * bump.log_radius.clamp(log_least, log_most));
        let s = bump.strength;
        let terms = std::array::from_fn(|index| {
            let (k, power) = (index / POWERS, index % POWERS);
            let (value, slope) = (f64::from(radius.value[k]), f64::from(radius.slope[k]));
            let (by_s, rising) = match power {
                0 => (s, 1.0),
                1 => (s * s, 2.0 * s),
                _ => (s * s * s, 3.0 * s * s),
            };
            [
                area * value * by_s,
                area * (2.0 * value + slope) * by_s,
                area * value * rising,
            ]
            .map(|term| term as f32)
        });
        Self {
            first_radius: radius.first,
            terms,
        }
    }
}

/// Weights of the four places around a point along one axis (Keys 1981, IEEE Trans. ASSP 29, eq. 15: cubic convolution).
struct Cubic {
    first: usize,
    value: [f32; 4],
    slope: [f32; 4],
}

impl Cubic {
    /// `at` in steps from the first of `count` points; kept between the second and the last but one.
    fn at(at: f64, count: usize) -> Self {
        let last = (count - 2) as f64;
        let at = at.clamp(1.0, last);
        let cell = libm::floor(at).min(last - 1.0);
        let f = at - cell;
        let (f2, f3) = (f * f, f * f * f);
        let value = [
            0.5 * (2.0 * f2 - f3 - f),
            0.5 * (3.0 * f3 - 5.0 * f2 + 2.0),
            0.5 * (4.0 * f2 - 3.0 * f3 + f),
            0.5 * (f3 - f2),
        ];
        let slope = [
            0.5 * (4.0 * f - 3.0 * f2 - 1.0),
            0.5 * (9.0 * f2 - 10.0 * f),
            0.5 * (8.0 * f - 9.0 * f2 + 1.0),
            0.5 * (3.0 * f2 - 2.0 * f),
        ];
        Self {
            first: cell as usize - 1,
            value: value.map(|weight| weight as f32),
            slope: slope.map(|weight| weight as f32),
        }
    }

    /// The same with its slope in units of which a step has so many.
    fn per(mut self, step: f64) -> Self {
        self.slope = self.slope.map(|slope| slope / step as f32);
        self
    }
}

fn add_scaled(target: &mut [f32], source: &[f32], factor: f32) {
    for (sum, value) in target.iter_mut().zip(source) {
        *sum += factor * value;
    }
}

#[cfg(test)]
impl ResponseTable {
    /// A small table of no pad: twelve channels, eight of them told, smooth over a box of 60 by 40 mm.
    pub(crate) fn small() -> Self {
        let (channels, rank) = (12, LANES);
        let places = Places::new([60.0, 40.0]);
        let mut basis = vec![0.0; rank * channels];
        for dimension in 0..rank {
            basis[dimension * channels + dimension] = 1.0;
        }
        let terms = (0..places.len() * RADII * POWERS * rank)
            .map(|index| {
                let place = places.at_mm(index / (RADII * POWERS * rank));
                let radius = (index / (POWERS * rank)) % RADII;
                let (power, dimension) = ((index / rank) % POWERS, index % rank);
                let phase = dimension as f64 + 0.3 * radius as f64;
                let wave = libm::sin(0.09 * place[0] + phase) + libm::cos(0.07 * place[1] - phase);
                (wave * 1e-3 / (1.0 + power as f64)) as f32
            })
            .collect();
        Self {
            key: "small".to_owned(),
            channels,
            rank,
            basis,
            places,
            terms,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn value(table: &ResponseTable, bump: &Bump) -> Vec<f32> {
        let mut response = Response::default();
        table.respond(bump, &mut response);
        response.value
    }

    proptest! {
        #[test]
        fn every_processor_gives_the_same_bits(
            x in 0.0..60.0f64, y in 0.0..40.0f64, log_radius in 0.5..3.0f64, strength in 0.1..0.7f64,
        ) {
            let table = ResponseTable::small();
            let bump = Bump { centre_mm: [x, y], log_radius, strength };
            let [mut ours, mut plain] = [(); 2].map(|()| Response::default());
            table.respond(&bump, &mut ours);
            // Not dispatched: as for a processor of which nothing is known.
            table.interpolation(&bump, &mut plain).call();
            let bits = |response: &Response| -> Vec<u32> {
                let all = response.derivatives.iter().flatten().chain(&response.value);
                all.map(|value| value.to_bits()).collect()
            };
            prop_assert_eq!(bits(&ours), bits(&plain));
        }

        #[test]
        fn derivatives_are_those_of_the_value(
            x in 2.0..58.0f64, y in 2.0..38.0f64, radius in 0.02..0.98f64, strength in 0.1..0.7f64,
        ) {
            let table = ResponseTable::small();
            let [least, most] = table.radii_mm().map(libm::log);
            let bump = Bump { centre_mm: [x, y], log_radius: least + radius * (most - least), strength };
            let mut response = Response::default();
            table.respond(&bump, &mut response);
            let moved = |k: usize, by: f64| {
                let mut moved = bump;
                match k {
                    0 | 1 => moved.centre_mm[k] += by,
                    2 => moved.log_radius += by,
                    _ => moved.strength += by,
                }
                value(&table, &moved)
            };
            for (k, step) in [0.02, 0.02, 0.002, 0.002].into_iter().enumerate() {
                let (before, after) = (moved(k, -step), moved(k, step));
                let largest = response.derivatives[k].iter().fold(0.0f32, |m, d| m.max(d.abs()));
                for (dimension, told) in response.derivatives[k].iter().enumerate() {
                    let slope = f64::from(after[dimension] - before[dimension]) / (2.0 * step);
                    let off = (slope - f64::from(*told)).abs();
                    prop_assert!(off < 0.02 * f64::from(largest) + 1e-4, "{k}: {slope} for {told}");
                }
            }
        }
    }

    #[test]
    fn nothing_responds_to_a_touch_without_strength() {
        let table = ResponseTable::small();
        let bump = Bump {
            centre_mm: [30.0, 20.0],
            log_radius: 1.0,
            strength: 0.0,
        };
        assert!(value(&table, &bump).iter().all(|v| *v == 0.0));
    }

    #[test]
    fn rise_and_strength_are_each_other() {
        for rise in [0.0, 0.3, 1.0, 5.0] {
            let bump = Bump {
                centre_mm: [0.0; 2],
                log_radius: 0.0,
                strength: strength_of(rise),
            };
            assert!((bump.rise() - rise).abs() < 1e-12);
        }
    }
}
