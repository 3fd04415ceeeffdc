//! Smooth changes of the whole pad: it bends, an edge dries, it warms unevenly.
//!
//! Such a change is small and reaches over the pad, so no finger explains it, but pieces of it look like faint fingers. It is
//! described by few patterns of conductivity: polynomials over the pad, and a decay from each edge.

use super::metric::{Metric, dot, energy};
use crate::eit::ResponseTable;
use crate::eit::response::{Shape, TouchModel, strength_from_rise};
use crate::pad::TouchSign;

/// Largest degree of the polynomials.
const DEGREE: usize = 5;
/// An edge dries over this share of the pad's longer side.
const EDGE_SHARE: f64 = 0.1;
/// The patterns are sums of the responses of faint touches that stand this share of the longer side apart.
const SPACING_SHARE: f64 = 0.04;
/// Their relative rise.
const FAINT_RISE: f64 = 0.02;
/// Patterns whose part that the others do not explain is below this share add nothing.
const LEAST_SHARE: f64 = 1e-2;
/// The patterns of a pad, for the weights of its channels.
#[derive(Clone, Debug)]
pub(super) struct Deformations {
    pub(super) rank: usize,
    /// Patterns x rank: orthonormal in whitened coordinates, ...
    pub(super) whitened: Vec<f32>,
    /// ... and the same in the table's coordinates.
    pub(super) coordinates: Vec<f32>,
}

impl Deformations {
    /// The patterns of a pad of the given size; none for tables of one sign, whose events stay as they were.
    pub(super) fn new(table: &ResponseTable, metric: &Metric, size_mm: [f64; 2]) -> Self {
        let mut all = Self {
            rank: table.rank(),
            whitened: Vec::new(),
            coordinates: Vec::new(),
        };
        if table.has_both_signs() {
            for pattern in patterns(table, size_mm) {
                all.add(pattern, metric);
            }
        }
        all
    }

    /// Adds what is new in a pattern.
    fn add(&mut self, mut coordinates: Vec<f32>, metric: &Metric) {
        let mut whitened = coordinates.clone();
        metric.whiten_coordinates(&mut whitened);
        let before = energy(&whitened);
        for (other, other_coordinates) in self
            .whitened
            .chunks_exact(self.rank)
            .zip(self.coordinates.chunks_exact(self.rank))
        {
            let along = dot(&whitened, other);
            for (value, part) in whitened.iter_mut().zip(other) {
                *value -= along * part;
            }
            for (value, part) in coordinates.iter_mut().zip(other_coordinates) {
                *value -= along * part;
            }
        }
        let left = energy(&whitened);
        if left < LEAST_SHARE * LEAST_SHARE * before || left <= 0.0 {
            return;
        }
        let scale = (1.0 / libm::sqrt(left)) as f32;
        self.whitened
            .extend(whitened.iter().map(|value| scale * value));
        self.coordinates
            .extend(coordinates.iter().map(|value| scale * value));
    }

    /// Squared deviations of a residual that the patterns explain.
    pub(super) fn gain(&self, residual: &[f32]) -> f64 {
        self.whitened
            .chunks_exact(self.rank)
            .map(|pattern| {
                let along = f64::from(dot(pattern, residual));
                along * along
            })
            .sum()
    }
}

/// The response of each pattern of conductivity, in the table's coordinates.
fn patterns(table: &ResponseTable, size_mm: [f64; 2]) -> Vec<Vec<f32>> {
    let [width, height] = size_mm;
    let longer_mm = width.max(height);
    let spacing_mm = SPACING_SHARE * longer_mm;
    let steps = size_mm.map(|side| (libm::round(side / spacing_mm) as usize).max(1));
    let weights = |[x, y]: [f64; 2]| -> Vec<f64> {
        let (u, v) = (2.0 * x / width - 1.0, 2.0 * y / height - 1.0);
        let polynomials = (0..=DEGREE)
            .flat_map(|i| (0..=DEGREE - i).map(move |j| (i, j)))
            .map(|(i, j)| libm::pow(u, i as f64) * libm::pow(v, j as f64));
        let decay_mm = EDGE_SHARE * longer_mm;
        let edges = [x, width - x, y, height - y].map(|off_mm| libm::exp(-off_mm / decay_mm));
        polynomials.chain(edges).collect()
    };
    let mut sums = vec![vec![0.0f32; table.rank()]; weights([0.0; 2]).len()];
    let mut response = Vec::new();
    let log_radius = libm::log(table.radii_mm()[0]);
    for row in 0..=steps[1] {
        for column in 0..=steps[0] {
            let centre_mm = [
                column as f64 * width / steps[0] as f64,
                row as f64 * height / steps[1] as f64,
            ];
            let touch = TouchModel {
                centre_mm,
                log_radius,
                strength: strength_from_rise(FAINT_RISE),
                sign: TouchSign::Rise,
                shape: Shape::Round,
            };
            table.respond_value(&touch, &mut response);
            for (sum, weight) in sums.iter_mut().zip(weights(centre_mm)) {
                for (total, value) in sum.iter_mut().zip(&response) {
                    *total += weight as f32 * value;
                }
            }
        }
    }
    sums
}
