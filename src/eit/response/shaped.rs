//! Fingers that are not round: long ones, palms, and rings, which are also fingers wider than the table.
//!
//! Such a finger is a few round touches that share their unknowns. What they do to each other is, to first order, a stretch
//! (`stretch.rs`) of a long finger, and another strength in the middle of a ring: with these, what is left of an ellipse of 15 x 6 mm is
//! 0.6 % of its response, of a ring or a finger of 15 mm 0.7 % and 0.2 % (without, 3.7 %, 4.4 % and 0.5 %).

use std::f64::consts::TAU;

use super::stretch::StretchResponse;
use super::table::{Response, ResponseTable};
use super::touch_model::{SHAPE_UNKNOWNS, Shape, TouchModel};
use crate::types::PointMm;

/// Parts of a long finger: place along its half length, share of the strength, and by how much they are narrower (log radius).
const LONG: [(f64, f64, f64); 3] = [(-1.0, 0.7, 0.1), (0.0, 1.0, 0.0), (1.0, 0.7, 0.1)];
/// Parts of a ring.
const RING: usize = 8;

/// A part of a touch, and how it depends on the shape.
struct Part {
    touch: TouchModel,
    /// Share of the touch's strength.
    share: f64,
    /// Derivatives of the place by the unknowns of the shape.
    by_shape: [[f64; 2]; SHAPE_UNKNOWNS],
    /// Derivative of the share by the third unknown.
    share_by_third: f64,
}

impl TouchModel {
    /// Round touches that are this one together.
    pub fn round_parts(&self) -> impl Iterator<Item = TouchModel> {
        self.parts().into_iter().map(|part| part.touch)
    }

    fn parts(&self) -> Vec<Part> {
        let part = |offset_mm: PointMm, share: f64, narrower: f64| Part {
            touch: TouchModel {
                centre_mm: [0, 1].map(|k| self.centre_mm[k] + offset_mm[k]),
                log_radius: self.log_radius - narrower,
                strength: share * self.strength,
                shape: Shape::Round,
                ..*self
            },
            share,
            by_shape: [[0.0; 2]; SHAPE_UNKNOWNS],
            share_by_third: 0.0,
        };
        match self.shape {
            Shape::Round => vec![part([0.0; 2], 1.0, 0.0)],
            Shape::Long { half_mm, .. } => LONG
                .iter()
                .map(|(along, share, narrower)| Part {
                    by_shape: [[*along, 0.0], [0.0, *along], [0.0; 2]],
                    ..part(half_mm.map(|half| along * half), *share, *narrower)
                })
                .collect(),
            Shape::Palm { half_mm, width_mm } => [-1.0, 1.0]
                .iter()
                .flat_map(|side| LONG.iter().map(move |part| (*side, part)))
                .map(|(side, (along, share, narrower))| {
                    let [hx, hy] = half_mm;
                    let length = libm::hypot(hx, hy).max(f64::MIN_POSITIVE);
                    let across = [-hy / length, hx / length];
                    let far = side * width_mm;
                    // The direction across turns with the half along.
                    let [x, y] = half_mm.map(|half| half / length);
                    let turned = far / length;
                    Part {
                        by_shape: [
                            [*along + turned * x * y, turned * y * y],
                            [-turned * x * x, *along - turned * x * y],
                            across.map(|across| side * across),
                        ],
                        ..part(
                            [0, 1].map(|k| along * half_mm[k] + far * across[k]),
                            *share,
                            *narrower,
                        )
                    }
                })
                .collect(),
            Shape::Ring { radius_mm, middle } => (0..RING)
                .map(|index| {
                    let angle = TAU * index as f64 / RING as f64;
                    let way = [libm::cos(angle), libm::sin(angle)];
                    Part {
                        by_shape: [way, [0.0; 2], [0.0; 2]],
                        ..part(way.map(|way| way * radius_mm), 1.0, 0.0)
                    }
                })
                .chain(std::iter::once(Part {
                    share_by_third: 1.0,
                    ..part([0.0; 2], middle, 0.0)
                }))
                .collect(),
        }
    }
}

/// The response of a touch of any shape, with its derivatives by the unknowns of the shape, and scratch memory.
#[derive(Clone, Debug, Default)]
pub struct ShapedResponse {
    /// The response and its derivatives by the unknowns of round touches.
    pub response: Response,
    /// Derivatives by the unknowns of the shape.
    pub by_shape: [Vec<f32>; SHAPE_UNKNOWNS],
    part: Response,
    stretch: StretchResponse,
}

impl ShapedResponse {
    fn clear(&mut self, rank: usize) {
        let Response { value, derivatives } = &mut self.response;
        let all = derivatives.iter_mut().chain(&mut self.by_shape);
        for values in all.chain([value]) {
            values.clear();
            values.resize(rank, 0.0);
        }
    }

    /// Adds the response of a part, which is in `part`.
    fn add_part(&mut self, part: &Part) {
        let [by_x, by_y, by_radius, by_strength] = &self.part.derivatives;
        let Response { value, derivatives } = &mut self.response;
        let [x, y, radius, strength] = derivatives;
        add(value, 1.0, &self.part.value);
        add(x, 1.0, by_x);
        add(y, 1.0, by_y);
        add(radius, 1.0, by_radius);
        add(strength, part.share, by_strength);
        for (sum, [dx, dy]) in self.by_shape.iter_mut().zip(part.by_shape) {
            add(sum, dx, by_x);
            add(sum, dy, by_y);
        }
    }

    /// Adds what a part of a long finger saturates less along the finger's axis.
    fn add_stretch(&mut self, part: &Part, half_mm: [f64; 2], stretch: f64) {
        let [hx, hy] = half_mm;
        let square = (hx * hx + hy * hy).max(f64::MIN_POSITIVE);
        let axis = [(hx * hx - hy * hy) / square, 2.0 * hx * hy / square];
        // How the axis turns with the two halves.
        let turned = [
            [4.0 * hx * hy * hy, 2.0 * hy * (hy * hy - hx * hx)],
            [-4.0 * hx * hx * hy, 2.0 * hx * (hx * hx - hy * hy)],
        ]
        .map(|by| by.map(|change| change / (square * square)));
        let size = libm::exp(2.0 * part.touch.log_radius);
        let of_strength = size * part.share;
        let of_part = size * part.touch.strength;
        let Response { value, derivatives } = &mut self.response;
        let [x, y, radius, strength] = derivatives;
        let [by_hx, by_hy, by_stretch] = &mut self.by_shape;
        for (k, [vector, vector_by_x, vector_by_y]) in self.stretch.axes.iter().enumerate() {
            let along = stretch * axis[k];
            add(value, along * of_part, vector);
            add(x, along * of_part, vector_by_x);
            add(y, along * of_part, vector_by_y);
            add(radius, 2.0 * along * of_part, vector);
            add(strength, along * of_strength, vector);
            add(by_stretch, axis[k] * of_part, vector);
            let [[along_x, _], [_, along_y], _] = part.by_shape;
            add(by_hx, along * of_part * along_x, vector_by_x);
            add(by_hy, along * of_part * along_y, vector_by_y);
            add(by_hx, stretch * turned[0][k] * of_part, vector);
            add(by_hy, stretch * turned[1][k] * of_part, vector);
        }
    }
}

impl ResponseTable {
    /// The response of a touch of any shape.
    pub fn respond_shaped(&self, touch: &TouchModel, shaped: &mut ShapedResponse) {
        shaped.clear(self.rank());
        for part in touch.parts() {
            self.respond_round(&part.touch, &mut shaped.part);
            shaped.add_part(&part);
            if part.share_by_third != 0.0 {
                let by_share = part.share_by_third * touch.strength;
                let [.., by_third] = &mut shaped.by_shape;
                add(by_third, by_share, &shaped.part.derivatives[3]);
            }
            if let Shape::Long { half_mm, stretch } = touch.shape
                && self.respond_to_stretch(part.touch.centre_mm, &mut shaped.stretch)
            {
                shaped.add_stretch(&part, half_mm, stretch);
            }
        }
    }
}

fn add(sums: &mut [f32], factor: f64, values: &[f32]) {
    if factor != 0.0 {
        crate::eit::cholesky::add_scaled(sums, values, factor as f32);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eit::response::places::Places;
    use crate::eit::response::stretch::Stretches;
    use crate::pad::TouchSign;
    use proptest::prelude::*;

    fn table() -> ResponseTable {
        let mut table = ResponseTable::small();
        let places = Places::new([60.0, 40.0]);
        let count = Stretches::count(&places, table.rank());
        let values = (0..count).map(|index| 1e-4 * libm::sinf(0.01 * index as f32));
        table.stretches = Some(Stretches::new(values.collect(), &places, table.rank()));
        table
    }

    fn with_unknowns(touch: &TouchModel, at: [f64; 7]) -> TouchModel {
        let [x, y, log_radius, strength, shape @ ..] = at;
        TouchModel {
            centre_mm: [x, y],
            log_radius,
            strength,
            shape: touch.shape.with_unknowns(shape),
            ..*touch
        }
    }

    proptest! {
        #[test]
        fn derivatives_are_those_of_the_value(
            x in 15.0..45.0f64, y in 15.0..25.0f64, kind in 0..3usize, falls in any::<bool>(),
            first in 1.0..7.0f64, second in -7.0..-1.0f64, third in 0.05..0.5f64,
        ) {
            let table = table();
            let shape = [
                Shape::Long { half_mm: [0.0; 2], stretch: 0.0 },
                Shape::Palm { half_mm: [0.0; 2], width_mm: 0.0 },
                Shape::Ring { radius_mm: 0.0, middle: 0.0 },
            ][kind];
            let least = libm::log(table.radii_mm()[0]);
            let touch = TouchModel {
                centre_mm: [x, y],
                log_radius: least + 0.3,
                strength: 0.3,
                sign: if falls { TouchSign::Fall } else { TouchSign::Rise },
                shape,
            };
            let at = [x, y, least + 0.3, 0.3, first, second, third];
            let respond = |at: [f64; 7]| {
                let mut shaped = ShapedResponse::default();
                table.respond_shaped(&with_unknowns(&touch, at), &mut shaped);
                shaped
            };
            let shaped = respond(at);
            let derivatives = shaped.response.derivatives.iter().chain(&shaped.by_shape);
            for (unknown, derivative) in derivatives.enumerate() {
                let step = if unknown == 2 || unknown == 3 { 2e-3 } else { 1e-2 };
                let moved = |by: f64| {
                    let mut moved = at;
                    moved[unknown] += by;
                    respond(moved).response.value
                };
                let (before, after) = (moved(-step), moved(step));
                let largest = derivative.iter().fold(0.0f32, |most, value| most.max(value.abs()));
                for (k, expected) in derivative.iter().enumerate() {
                    let slope = f64::from(after[k] - before[k]) / (2.0 * step);
                    let off = (slope - f64::from(*expected)).abs();
                    prop_assert!(off < 0.03 * f64::from(largest) + 2e-4, "{unknown}: {slope} for {expected}");
                }
            }
        }
    }

    #[test]
    fn a_round_finger_is_one_part() {
        let table = table();
        let round = TouchModel {
            centre_mm: [30.0, 20.0],
            log_radius: 1.6,
            strength: 0.1,
            sign: TouchSign::Rise,
            shape: Shape::Round,
        };
        let mut shaped = ShapedResponse::default();
        table.respond_shaped(&round, &mut shaped);
        let mut response = Response::default();
        table.respond(&round, &mut response);
        assert_eq!(shaped.response, response);
    }
}
