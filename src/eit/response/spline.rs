//! Cubic splines through values on a grid.
//!
//! A spline through the responses at the places of a table is closer to the responses between them than cubic convolution is,
//! and costs the same four weights along each axis; but its coefficients are not the values, and have to be found first (Unser 1999,
//! IEEE Signal Processing Magazine 16(6), "Splines: a perfect fit for signal and image processing").

use super::places::{Places, RADII};
use super::symmetry::Orbits;
use super::terms::{POWERS, SIGNS, Terms};

/// The coefficients of splines in place and radius through the terms of a table at its solved places: signs x solved places x radii x
/// powers x rank. `basis` is that of the table.
pub(super) fn through_terms(
    terms: Vec<f32>,
    rank: usize,
    orbits: &Orbits,
    places: &Places,
    basis: &[f32],
) -> Vec<f32> {
    let stride = POWERS * rank;
    let of_place = RADII * stride;
    let terms = Terms::new(terms, rank, orbits.clone(), basis);
    let solved: Vec<usize> = (0..places.len())
        .filter(|place| orbits.is_solved(*place))
        .collect();
    let mut all = vec![0.0f32; SIGNS * solved.len() * of_place];
    let mut grid = vec![0.0f64; places.len() * stride];
    for sign in 0..SIGNS {
        for radius in 0..RADII {
            for (place, vectors) in grid.chunks_exact_mut(stride).enumerate() {
                let at_place = terms.at(sign, place, radius);
                for (value, term) in vectors.iter_mut().zip(at_place) {
                    *value = f64::from(*term);
                }
            }
            for row in grid.chunks_exact_mut(places.columns * stride) {
                to_coefficients(row, places.columns, stride);
            }
            to_coefficients(&mut grid, places.rows, places.columns * stride);
            for (number, place) in solved.iter().enumerate() {
                let first = (sign * solved.len() + number) * of_place + radius * stride;
                let found = &grid[place * stride..(place + 1) * stride];
                for (value, found) in all[first..first + stride].iter_mut().zip(found) {
                    *value = *found as f32;
                }
            }
        }
    }
    let mut radii = vec![0.0f64; of_place];
    for vectors in all.chunks_exact_mut(of_place) {
        for (value, term) in radii.iter_mut().zip(&*vectors) {
            *value = f64::from(*term);
        }
        to_coefficients(&mut radii, RADII, stride);
        for (value, found) in vectors.iter_mut().zip(&radii) {
            *value = *found as f32;
        }
    }
    all
}

/// Replaces vectors of `length`, one after the other, by the coefficients of the spline through all of them but the first and the
/// last, which only give it its bend at its ends.
///
/// # Panics
/// If there are not `count` vectors, four or more.
fn to_coefficients(values: &mut [f64], count: usize, length: usize) {
    assert!(count >= 4 && values.len() == count * length);
    let last = count - 1;
    // A spline of coefficients c is (c[i-1] + 4 c[i] + c[i+1]) / 6 at point i, and bends there by c[i-1] - 2 c[i] + c[i+1].
    let ends = [[0, 1, 2], [last, last - 1, last - 2]];
    let outer = ends.map(|points| -> Vec<[f64; 2]> {
        let [outer, own, inner] = points.map(|point| &values[point * length..][..length]);
        let bend = outer.iter().zip(own).zip(inner);
        bend.map(|((outer, own), inner)| [*own, own - (outer - 2.0 * own + inner) / 6.0])
            .collect()
    });
    for (outer, [_, point, _]) in outer.iter().zip(ends) {
        for (value, [_, coefficient]) in values[point * length..].iter_mut().zip(outer) {
            *value = *coefficient;
        }
    }
    // Elimination, and back: 4 on the diagonal, 1 beside it.
    let mut shares = vec![0.0; count];
    for point in 2..last - 1 {
        let share = 1.0 / (4.0 - shares[point - 1]);
        let (before, own) = values.split_at_mut(point * length);
        for (value, before) in own.iter_mut().zip(&before[(point - 1) * length..]) {
            *value = (6.0 * *value - before) * share;
        }
        shares[point] = share;
    }
    for point in (2..last - 1).rev() {
        let (own, after) = values.split_at_mut((point + 1) * length);
        for (value, after) in own[point * length..].iter_mut().zip(after) {
            *value -= shares[point] * *after;
        }
    }
    for (outer, [end, first, second]) in outer.iter().zip(ends) {
        for (k, [value, _]) in outer.iter().enumerate() {
            let [first, second] = [first, second].map(|point| values[point * length + k]);
            values[end * length + k] = 6.0 * value - 4.0 * first - second;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eit::response::cubic::{Cubic, Interpolant};

    #[test]
    fn a_spline_passes_through_its_values_and_is_exact_for_parabolas() {
        const COUNT: usize = 9;
        let f = |at: f64| [1.0 + 0.5 * at - 0.3 * at * at, libm::sin(1.3 * at)];
        let mut coefficients: Vec<f64> = (0..COUNT).flat_map(|at| f(at as f64)).collect();
        to_coefficients(&mut coefficients, COUNT, 2);
        for step in 0..=60 {
            let at = 1.0 + 0.1 * f64::from(step);
            let cubic = Cubic::at(Interpolant::Spline, at, COUNT);
            let sum = |k: usize| -> f64 {
                let weights = cubic.value.iter().enumerate();
                weights
                    .map(|(i, weight)| f64::from(*weight) * coefficients[2 * (cubic.first + i) + k])
                    .sum()
            };
            assert!((sum(0) - f(at)[0]).abs() < 1e-5, "{at}: {}", sum(0));
            let within = if step % 10 == 0 { 1e-5 } else { 0.06 };
            assert!((sum(1) - f(at)[1]).abs() < within, "{at}: {}", sum(1));
        }
    }
}
