//! Interpolation in the response table: cubic in place and radius, in strength as `law.rs` says.
//!
//! Being piecewise cubic, a response has the continuous derivatives that a fit needs.
//!
//! Invariant: sums run in an order fixed by this source, so the same table gives the same bits on every processor,
//! whatever the width of its vectors.

use pulp::{Arch, NullaryFnOnce};

use super::LANES;
use super::cubic::Cubic;
use super::law::StrengthLaw;
use super::places::{Places, RADII, RADIUS_STEP};
use super::shaped::ShapedResponse;
use super::table::{Response, ResponseTable};
use super::terms::POWERS;
use super::touch_model::{Shape, TouchModel};
use crate::pad::TouchSign;

impl ResponseTable {
    /// The response of a touch and its derivatives. Outside the table's places the nearest place is used, outside the
    /// table's radii the nearest radius.
    pub fn respond(&self, touch: &TouchModel, response: &mut Response) {
        if touch.shape == Shape::Round {
            self.respond_round(touch, response);
        } else {
            // Fingers of odd shape are rare: their scratch memory is not kept.
            let mut shaped = ShapedResponse::default();
            self.respond_shaped(touch, &mut shaped);
            *response = shaped.response;
        }
    }

    /// The same for a round touch.
    pub(super) fn respond_round(&self, touch: &TouchModel, response: &mut Response) {
        Arch::new().dispatch(Interpolation::new(self, touch, response));
    }

    /// The value of [`ResponseTable::respond`] of a round touch alone, the same to the bit. Fast for touches at grid points with a radius of the
    /// table: terms of weight 0 are not turned.
    pub fn respond_value(&self, touch: &TouchModel, value: &mut Vec<f32>) {
        value.clear();
        value.resize(self.rank, 0.0);
        let size = SizeWeights::new(touch, &self.places, self.law);
        let [across, up] = self.cubics(touch);
        let sign = self.sign_index(touch);
        let mut at_place = vec![0.0f32; self.rank];
        for index in 0..16 {
            let (j, i) = (index / 4, index % 4);
            let weight = across.value[i] * up.value[j];
            if weight == 0.0 {
                continue;
            }
            let place = (up.first + j) * self.places.columns + across.first + i;
            at_place.fill(0.0);
            for (k, factors) in size.terms.chunks_exact(POWERS).enumerate() {
                if factors.iter().all(|[value, ..]| *value == 0.0) {
                    continue;
                }
                let rows = self.terms.at(sign, place, size.first_radius + k);
                for (row, [factor, ..]) in rows.chunks_exact(self.rank).zip(factors) {
                    for (sum, term) in at_place.iter_mut().zip(row) {
                        *sum += factor * term;
                    }
                }
            }
            for (total, sum) in value.iter_mut().zip(&at_place) {
                *total += weight * sum;
            }
        }
    }

    /// The weights of places along x and y.
    fn cubics(&self, touch: &TouchModel) -> [Cubic; 2] {
        let Places {
            pitch_mm,
            columns,
            rows,
            ..
        } = self.places;
        let margin = self.places.margin as f64;
        let [x, y] = touch.centre_mm;
        [(x, columns), (y, rows)]
            .map(|(at_mm, count)| Cubic::at(at_mm / pitch_mm + margin, count).per(pitch_mm))
    }

    fn sign_index(&self, touch: &TouchModel) -> usize {
        usize::from(touch.sign == TouchSign::Fall && self.has_both_signs())
    }
}

/// The sums of [`ResponseTable::respond`], dispatched by processor: only code inlined here is compiled for each.
pub(super) struct Interpolation<'a> {
    table: &'a ResponseTable,
    /// The terms of the touch's sign at the sixteen places around it, row by row, for the four radii around its own.
    terms: [[&'a [f32]; 4]; 16],
    size: SizeWeights,
    across: Cubic,
    up: Cubic,
    response: &'a mut Response,
}

impl<'a> Interpolation<'a> {
    pub(super) fn new(
        table: &'a ResponseTable,
        touch: &TouchModel,
        response: &'a mut Response,
    ) -> Self {
        let derivatives = response.derivatives.iter_mut();
        for values in derivatives.chain([&mut response.value]) {
            values.clear();
            values.resize(table.rank, 0.0);
        }
        let [across, up] = table.cubics(touch);
        let sign = table.sign_index(touch);
        let size = SizeWeights::new(touch, &table.places, table.law);
        let terms = std::array::from_fn(|index| {
            let (row, column) = (up.first + index / 4, across.first + index % 4);
            let place = row * table.places.columns + column;
            std::array::from_fn(|k| table.terms.at(sign, place, size.first_radius + k))
        });
        Self {
            table,
            terms,
            size,
            across,
            up,
            response,
        }
    }
}

impl NullaryFnOnce for Interpolation<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self {
            table,
            terms,
            size,
            across,
            up,
            response,
        } = self;
        let rank = table.rank;
        // A few dimensions at a time, so that the sums stay in registers.
        for first in (0..rank).step_by(LANES) {
            let mut sums = [[0.0f32; LANES]; 5];
            for (index, terms) in terms.iter().enumerate() {
                let (j, i) = (index / 4, index % 4);
                let [value, by_radius, by_strength] = response_at(terms, first, rank, &size.terms);
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

/// The response at one place and its derivatives by log radius and strength, in [`LANES`] dimensions from `first`.
#[inline(always)]
fn response_at(
    terms: &[&[f32]; 4],
    first: usize,
    rank: usize,
    factors: &[[f32; 3]; 4 * POWERS],
) -> [[f32; LANES]; 3] {
    let mut sums = [[0.0f32; LANES]; 3];
    for (of_radius, factors) in terms.iter().zip(factors.chunks_exact(POWERS)) {
        for (power, [value, by_radius, by_strength]) in factors.iter().enumerate() {
            let Some(row) = of_radius[power * rank + first..].first_chunk::<LANES>() else {
                break;
            };
            for lane in 0..LANES {
                sums[0][lane] += value * row[lane];
                sums[1][lane] += by_radius * row[lane];
                sums[2][lane] += by_strength * row[lane];
            }
        }
    }
    sums
}

/// Weights of the terms at four radii: area x the law's factors.
struct SizeWeights {
    first_radius: usize,
    /// Radii x powers: the weight, its derivative by log radius, its derivative by strength.
    terms: [[f32; 3]; 4 * POWERS],
}

impl SizeWeights {
    fn new(touch: &TouchModel, places: &Places, law: StrengthLaw) -> Self {
        let step = libm::log(RADIUS_STEP);
        let least = libm::log(places.least_radius_mm());
        let radius = Cubic::at((touch.log_radius - least) / step, RADII).per(step);
        let log_least = least + step;
        let log_most = least + step * (RADII - 2) as f64;
        let area = libm::exp(2.0 * touch.log_radius.clamp(log_least, log_most));
        let factors = law.factors(touch.strength);
        let terms = std::array::from_fn(|index| {
            let (k, power) = (index / POWERS, index % POWERS);
            let (value, slope) = (f64::from(radius.value[k]), f64::from(radius.slope[k]));
            let [factor, rising] = factors[power];
            [
                area * value * factor,
                area * (2.0 * value + slope) * factor,
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn value(table: &ResponseTable, touch: &TouchModel) -> Vec<f32> {
        let mut response = Response::default();
        table.respond(touch, &mut response);
        response.value
    }

    proptest! {
        #[test]
        fn every_processor_gives_the_same_bits(
            x in 0.0..60.0f64, y in 0.0..40.0f64, log_radius in 0.5..3.0f64, strength in 0.1..0.7f64,
            rises in any::<bool>(),
        ) {
            let table = ResponseTable::small();
            let sign = if rises { TouchSign::Rise } else { TouchSign::Fall };
            let touch = TouchModel { centre_mm: [x, y], log_radius, strength, sign, shape: Shape::Round };
            let [mut ours, mut plain] = [(); 2].map(|()| Response::default());
            table.respond(&touch, &mut ours);
            // Not dispatched: compiled for the baseline processor.
            Interpolation::new(&table, &touch, &mut plain).call();
            let bits = |response: &Response| -> Vec<u32> {
                let all = response.derivatives.iter().flatten().chain(&response.value);
                all.map(|value| value.to_bits()).collect()
            };
            prop_assert_eq!(bits(&ours), bits(&plain));
        }

        #[test]
        fn the_value_alone_has_the_same_bits(
            x in -10.0..70.0f64, y in -10.0..50.0f64, log_radius in 0.5..3.0f64, strength in 0.1..0.7f64,
            rises in any::<bool>(), is_on_grid in any::<bool>(),
        ) {
            let table = ResponseTable::small();
            let pitch_mm = table.places.pitch_mm;
            let snap = |at: f64| if is_on_grid { (at / pitch_mm).round() * pitch_mm } else { at };
            let log_radius = if is_on_grid { table.places.radii_mm()[2].ln() } else { log_radius };
            let sign = if rises { TouchSign::Rise } else { TouchSign::Fall };
            let touch = TouchModel { centre_mm: [snap(x), snap(y)], log_radius, strength, sign, shape: Shape::Round };
            let mut alone = Vec::new();
            table.respond_value(&touch, &mut alone);
            let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(&alone), bits(&value(&table, &touch)));
        }

        #[test]
        fn derivatives_are_those_of_the_value(
            x in 2.0..58.0f64, y in 2.0..38.0f64, radius in 0.02..0.98f64, strength in 0.1..0.7f64,
        ) {
            let table = ResponseTable::small();
            let [least, most] = table.radii_mm().map(libm::log);
            let log_radius = least + radius * (most - least);
            let touch = TouchModel { centre_mm: [x, y], log_radius, strength, sign: TouchSign::Fall, shape: Shape::Round };
            let mut response = Response::default();
            table.respond(&touch, &mut response);
            let moved = |k: usize, by: f64| {
                let mut moved = touch;
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
                for (dimension, expected) in response.derivatives[k].iter().enumerate() {
                    let slope = f64::from(after[dimension] - before[dimension]) / (2.0 * step);
                    let off = (slope - f64::from(*expected)).abs();
                    prop_assert!(off < 0.02 * f64::from(largest) + 1e-4, "{k}: {slope} for {expected}");
                }
            }
        }
    }

    #[test]
    fn nothing_responds_to_a_touch_without_strength() {
        let table = ResponseTable::small();
        let touch = TouchModel {
            centre_mm: [30.0, 20.0],
            log_radius: 1.0,
            strength: 0.0,
            sign: TouchSign::Rise,
            shape: Shape::Round,
        };
        assert!(value(&table, &touch).iter().all(|v| *v == 0.0));
    }
}
