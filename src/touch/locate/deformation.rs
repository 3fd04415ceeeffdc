//! Smooth changes of the whole pad: it bends, an edge dries, it warms unevenly.
//!
//! Such a change is small and reaches over the pad, so no finger explains it, but pieces of it look like faint fingers. It is
//! described by few patterns of conductivity: polynomials over the pad, and a decay from each edge. Where they explain a
//! residual better than a finger does, the reference moves by what they explain.

use super::locator::Locator;
use super::metric::{Metric, dot, energy};
use crate::eit::ResponseTable;
use crate::eit::response::{Response, TouchModel, strength_from_rise};
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
/// A deformation explains at least this many squared deviations: noise does once in minutes, and then it costs nothing.
const LEAST_GAIN: f64 = 60.0;
/// Under touches it explains this share of their model error as well. It may be less than all of it, for what was wrong is
/// smooth and is taken back when they lift.
const ERROR_SHARE: f64 = 0.25;
/// Touches that leave more than this many times noise and model error are not yet found.
const SETTLED_REST: f64 = 3.0;
/// It explains, beyond noise, this many times what a finger explains.
const BETTER: f64 = 1.2;
/// It changes readings by less than this share from one frame to the next (root mean square); a palm changes them by more.
const MOST_CHANGE: f64 = 4e-3;

/// The patterns of a pad, for the weights of its channels.
#[derive(Clone, Debug)]
pub(super) struct Deformations {
    rank: usize,
    /// Patterns x rank: orthonormal in whitened coordinates, ...
    whitened: Vec<f32>,
    /// ... and the same in the table's coordinates.
    coordinates: Vec<f32>,
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
    fn gain(&self, residual: &[f32]) -> f64 {
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
    let mut response = Response::default();
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
            };
            table.respond(&touch, &mut response);
            for (sum, weight) in sums.iter_mut().zip(weights(centre_mm)) {
                for (total, value) in sum.iter_mut().zip(&response.value) {
                    *total += weight as f32 * value;
                }
            }
        }
    }
    sums
}

impl Locator {
    /// Whether a deformation of the pad explains a residual better than a finger does; `noise` is the variance of the
    /// residual's readings.
    pub(super) fn is_deformed(&self, residual: &[f32], noise: f64) -> bool {
        let patterns = &self.model.deformations;
        let gain = patterns.gain(residual);
        if gain < LEAST_GAIN * noise + ERROR_SHARE * self.model_error() {
            return false;
        }
        let by_noise = noise * (patterns.whitened.len() / patterns.rank) as f64;
        self.peak(residual)
            .is_none_or(|peak| BETTER * peak.gain < gain - by_noise)
    }

    /// Whether the touches of the fit explain the frame well enough to look for a deformation in what they leave: they are
    /// found, and do not move.
    pub(super) fn is_settled(&self, noise: f64) -> bool {
        self.fit.touches.is_empty()
            || self.quality(noise).rest < SETTLED_REST
                && self
                    .motions
                    .iter()
                    .all(|motion| motion.step_mm() == [0.0; 2])
    }

    /// Takes a frame in which no touch is down, and a deformation out of it.
    pub fn take_untouched(&mut self, changes: &[f32], noise: f64) {
        self.deformation.clear();
        if self.model.deformations.whitened.is_empty() || !self.fit.touches.is_empty() {
            return;
        }
        self.take_frame(changes, noise);
        if self.is_deformed(&self.frame.coordinates, noise) {
            let residual = self.frame.coordinates.clone();
            self.take_deformation(&residual);
        }
    }

    /// Takes what the patterns explain of a residual out of the frame, and fits the touches again. Returns whether it did: not
    /// if it is more than a pad deforms by.
    pub(super) fn take_deformation(&mut self, residual: &[f32]) -> bool {
        let model = &self.model;
        let rank = model.deformations.rank;
        let mut change = vec![0.0f32; rank];
        let mut rest = self.frame.coordinates.clone();
        for (pattern, coordinates) in model
            .deformations
            .whitened
            .chunks_exact(rank)
            .zip(model.deformations.coordinates.chunks_exact(rank))
        {
            let along = dot(pattern, residual);
            for (total, value) in change.iter_mut().zip(coordinates) {
                *total += along * value;
            }
            for (value, part) in rest.iter_mut().zip(pattern) {
                *value -= along * part;
            }
        }
        // The table's basis is orthonormal: this is the sum over all channels.
        let channels = model.table.channels() as f64;
        if energy(&change) > MOST_CHANGE * MOST_CHANGE * channels {
            return false;
        }
        self.frame.energy += energy(&rest) - energy(&self.frame.coordinates);
        self.frame.coordinates = rest;
        if self.deformation.is_empty() {
            self.deformation = change;
        } else {
            for (total, value) in self.deformation.iter_mut().zip(&change) {
                *total += value;
            }
        }
        self.fit_again();
        true
    }

    /// The relative change of each channel by the deformation of the last frame, if there is one.
    pub fn deformation(&self) -> Option<Vec<f32>> {
        if self.deformation.is_empty() {
            return None;
        }
        let mut changes = vec![0.0; self.model.table.channels()];
        self.model.table.expand(&self.deformation, &mut changes);
        Some(changes)
    }
}
