//! The fit of one finger to the readings of some parts: place, size and strength, and how sure the place is.
//!
//! Levenberg-Marquardt, as in `locate/fit.rs`, but on readings instead of whole frames: size and strength have the prior of a
//! finger, and the model's error, a share of each reading's response, counts as noise.

use nalgebra::{Matrix4, Vector4};
use pulp::{Arch, NullaryFnOnce};

use super::readings::{MODEL_ERROR, PartReadings};
use crate::eit::ResponseTable;
use crate::eit::response::{MOST_STRENGTH, Response, TouchModel};

/// A step moves a finger at most this far, mm, ...
const LONGEST_MM: f64 = 6.0;
/// ... and changes log radius and strength by at most this.
const LONGEST: f64 = 0.3;
/// Standard deviations of log radius and strength between fingers.
const SPREAD: [f64; 2] = [0.35, 0.3];
/// A fit ends when a step explains less than this more, squared deviations: decisions need no more.
const SETTLED: f64 = 0.1;
/// Damping of the first step: a typical finger in the middle of a cell of 10 mm is not near enough for a whole one. A finger that
/// was fitted before keeps near its place, too: undamped, more touches that nobody made are seen.
const FIRST_DAMPING: f64 = 1.0;
/// Channels that are summed together.
const LANES: usize = 8;
/// Smallest strength.
const LEAST_STRENGTH: f64 = 0.01;

/// Where a finger may be, and what is typical.
#[derive(Clone, Copy, Debug)]
pub(super) struct FingerBounds {
    pub(super) typical: TouchModel,
    pub(super) size_mm: [f64; 2],
    /// Smallest and largest log radius.
    pub(super) log_radius: [f64; 2],
}

/// A fitted finger.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fitted {
    pub(super) touch: TouchModel,
    /// Sum of squared deviations before and after the fit, and of readings.
    pub(super) energy: f64,
    pub(super) rest: f64,
    pub(super) readings: f64,
    /// What is left, with the prior of size and strength.
    pub(super) cost: f64,
    /// Standard deviation of its place, mm.
    pub(super) place_mm: f64,
}

/// Memory of a fit.
#[derive(Clone, Debug, Default)]
pub(super) struct FitMemory {
    pub(super) response: Response,
    /// The response and its derivatives by x, y, log radius and strength, at the channels of a part.
    columns: [Vec<f32>; 5],
}

/// The normal equations at a finger.
#[derive(Clone, Copy)]
struct Normal {
    matrix: Matrix4<f64>,
    gradient: Vector4<f64>,
    cost: f64,
    energy: f64,
    rest: f64,
    readings: f64,
}

/// Fits a finger to readings, in at most `steps` steps. `None` if nothing can be fitted.
pub(super) fn fit<'a>(
    table: &ResponseTable,
    bounds: &FingerBounds,
    (start, steps): (TouchModel, usize),
    parts: impl Iterator<Item = &'a PartReadings> + Clone,
    memory: &mut FitMemory,
) -> Option<Fitted> {
    let mut touch = start;
    let mut best: Option<(TouchModel, Normal)> = None;
    let mut damping = FIRST_DAMPING;
    for _ in 0..steps {
        let normal = Normal::at(table, bounds, &touch, parts.clone(), memory);
        match &best {
            Some((_, before)) if normal.cost >= before.cost => damping *= 10.0,
            before => {
                let is_settled =
                    before.is_some_and(|(_, before)| before.cost - normal.cost < SETTLED);
                damping *= 0.3;
                best = Some((touch, normal));
                if is_settled {
                    break;
                }
            }
        }
        let (from, normal) = best.as_ref()?;
        let mut damped = normal.matrix;
        for k in 0..4 {
            damped[(k, k)] *= 1.0 + damping;
        }
        let step = damped.cholesky()?.solve(&normal.gradient);
        touch = moved(from, step, bounds);
        // Near the end a step does as the slopes say: it needs no other look at the readings.
        if step.dot(&normal.gradient) < SETTLED {
            best = best.map(|(_, normal)| (touch, normal));
            break;
        }
    }
    let (touch, normal) = best?;
    let covariance = normal.matrix.try_inverse()?;
    let place_mm = libm::sqrt(covariance[(0, 0)].max(covariance[(1, 1)]).max(0.0));
    Some(Fitted {
        touch,
        energy: normal.energy,
        rest: normal.rest,
        readings: normal.readings,
        cost: normal.cost,
        place_mm,
    })
}

fn moved(from: &TouchModel, step: Vector4<f64>, bounds: &FingerBounds) -> TouchModel {
    let mut touch = *from;
    for k in 0..2 {
        let at_mm = from.centre_mm[k] + step[k].clamp(-LONGEST_MM, LONGEST_MM);
        touch.centre_mm[k] = at_mm.clamp(0.0, bounds.size_mm[k]);
    }
    let [least, most] = bounds.log_radius;
    touch.log_radius = (from.log_radius + step[2].clamp(-LONGEST, LONGEST)).clamp(least, most);
    touch.strength =
        (from.strength + step[3].clamp(-LONGEST, LONGEST)).clamp(LEAST_STRENGTH, MOST_STRENGTH);
    touch
}

impl FitMemory {
    /// Expands the response and its derivatives at the channels of a part.
    fn expand(&mut self, table: &ResponseTable, readings: &PartReadings) {
        let span = readings.span();
        for column in &mut self.columns {
            column.clear();
            column.resize(span.len(), 0.0);
        }
        let [x, y, radius, strength] = &self.response.derivatives;
        Arch::new().dispatch(Expansion {
            table,
            first: span.start,
            coordinates: [&self.response.value, x, y, radius, strength],
            columns: &mut self.columns,
        });
    }
}

/// Sums over the dimensions of a table, dispatched by processor: only code inlined here is compiled for each. Half of the time of a fit
/// is spent here, so the sums of a few channels stay in registers.
struct Expansion<'a> {
    table: &'a ResponseTable,
    /// The part's first channel.
    first: usize,
    coordinates: [&'a [f32]; 5],
    columns: &'a mut [Vec<f32>; 5],
}

impl NullaryFnOnce for Expansion<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let channels = self.columns[0].len();
        let mut done = 0;
        while done < channels {
            // The last lanes overlap those before: a channel's sum is the same in any lane.
            let at = done.min(channels.saturating_sub(LANES));
            let lanes = LANES.min(channels);
            let mut sums = [[0.0f32; LANES]; 5];
            for dimension in 0..self.coordinates[0].len() {
                let row = &self.table.basis_row(dimension)[self.first + at..];
                let mut entries = [0.0f32; LANES];
                match row.first_chunk::<LANES>() {
                    Some(whole) if lanes == LANES => entries = *whole,
                    _ => entries[..lanes].copy_from_slice(&row[..lanes]),
                }
                for (sums, coordinates) in sums.iter_mut().zip(&self.coordinates) {
                    for (sum, entry) in sums.iter_mut().zip(&entries) {
                        *sum += coordinates[dimension] * entry;
                    }
                }
            }
            for (column, sums) in self.columns.iter_mut().zip(&sums) {
                column[at..at + lanes].copy_from_slice(&sums[..lanes]);
            }
            done = at + lanes;
        }
    }
}

impl Normal {
    fn at<'a>(
        table: &ResponseTable,
        bounds: &FingerBounds,
        touch: &TouchModel,
        parts: impl Iterator<Item = &'a PartReadings>,
        memory: &mut FitMemory,
    ) -> Self {
        table.respond(touch, &mut memory.response);
        let off = [
            (touch.log_radius - bounds.typical.log_radius) / SPREAD[0],
            (touch.strength - bounds.typical.strength) / SPREAD[1],
        ];
        let mut matrix = Matrix4::zeros();
        let mut gradient = Vector4::zeros();
        for k in 0..2 {
            matrix[(2 + k, 2 + k)] = 1.0 / (SPREAD[k] * SPREAD[k]);
            gradient[2 + k] = -off[k] / SPREAD[k];
        }
        let (mut energy, mut rest, mut readings) = (0.0, 0.0, 0.0);
        for part in parts {
            memory.expand(table, part);
            let columns = &memory.columns;
            for (k, (_, change, precision)) in part.iter().enumerate() {
                if precision <= 0.0 {
                    continue;
                }
                let explained = f64::from(columns[0][k]);
                // Of the reading, not of the fit: or a larger finger would always fit better.
                let model = MODEL_ERROR * change;
                let precision = precision / (1.0 + precision * model * model);
                let left = change - explained;
                let slope = Vector4::from_fn(|axis, _| f64::from(columns[1 + axis][k]));
                energy += change * change * precision;
                rest += left * left * precision;
                readings += 1.0;
                matrix += precision * slope * slope.transpose();
                gradient += precision * left * slope;
            }
        }
        Self {
            matrix,
            gradient,
            cost: rest + off[0] * off[0] + off[1] * off[1],
            energy,
            rest,
            readings,
        }
    }
}
