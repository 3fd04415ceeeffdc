//! What one frame allows: the least mean error of place of a faint finger (a rise of 10 %) that any method can have, were the pad, the
//! noise and the distribution of fingers known exactly. docs/accuracy.md quotes it beside the errors of play.
//! `GELPAD_FULL=1` draws 1,000 fingers instead of 200.
//!
//! All places, radii and rises that fingers have are weighed by their likelihood; the place with the least mean distance to what
//! is then likely has the least mean error (Bayes). The pad is the response table.

mod lattice;

use gelpad::cache;
use gelpad::eit::ResponseTable;
use gelpad::eit::response::{Response, Shape, TouchModel, strength_from_rise};
use gelpad::pad::TouchSign;
use gelpad::types::PointMm;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, Uniform};
use rayon::prelude::*;

/// Fingers are drawn as by `gelpad accuracy --real`: radii, mm, and the distance of centres from the edge.
const RADII_MM: [f64; 2] = [5.0, 9.0];
const INSET_MM: f64 = 10.0;
const RISE: f64 = 0.1;
/// The step of the places and radii that are weighed, mm.
const STEP_MM: f64 = 0.5;
/// Standard deviation of a reading, as a share of it: 60 dB.
const NOISE: f64 = 1e-3;

/// What a finger of [`RISE`] that may be there does to the readings, in standard deviations of the noise.
struct Candidate {
    centre_mm: PointMm,
    change: Vec<f64>,
    /// The sum of the squares of `change`.
    energy: f64,
}

fn change(table: &ResponseTable, centre_mm: PointMm, radius_mm: f64) -> Vec<f64> {
    let touch = TouchModel {
        centre_mm,
        log_radius: radius_mm.ln(),
        strength: strength_from_rise(RISE),
        sign: TouchSign::Rise,
        shape: Shape::Round,
    };
    let mut response = Response::default();
    table.respond(&touch, &mut response);
    let values = response.value.iter();
    values.map(|value| f64::from(*value) / NOISE).collect()
}

fn steps([from, to]: [f64; 2]) -> impl Iterator<Item = f64> {
    let count = ((to - from) / STEP_MM) as usize;
    (0..=count).map(move |step| from + STEP_MM * step as f64)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The place with the least mean distance to weighted places (Weiszfeld's algorithm), starting from their mean.
fn least_mean_distance(places: &[(PointMm, f64)]) -> PointMm {
    let mean_of = |weigh: &dyn Fn(&(PointMm, f64)) -> f64| {
        let mut sums = [0.0; 3];
        for place in places {
            let weight = weigh(place);
            sums[0] += weight * place.0[0];
            sums[1] += weight * place.0[1];
            sums[2] += weight;
        }
        [sums[0] / sums[2], sums[1] / sums[2]]
    };
    let mut at = mean_of(&|place| place.1);
    for _ in 0..30 {
        at = mean_of(&|(place, weight)| weight / apart_mm(*place, at).max(1e-3));
    }
    at
}

fn apart_mm(a: PointMm, b: PointMm) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The best estimate of a finger's place: that with the least mean distance to all candidates, weighed by their likelihood, for rises that
/// are one of these multiples of [`RISE`]. `along` is the product of the readings and each candidate's change.
fn best_place(along: &[f64], candidates: &[Candidate], rises: &[f64]) -> PointMm {
    // Squared deviations, less those of the untouched pad.
    let costs: Vec<Vec<f64>> = candidates
        .iter()
        .zip(along)
        .map(|(candidate, along)| {
            let cost = |rise: &f64| rise * (rise * candidate.energy - 2.0 * along);
            rises.iter().map(cost).collect()
        })
        .collect();
    let least = costs
        .iter()
        .flatten()
        .copied()
        .fold(f64::INFINITY, f64::min);
    let likelihoods = costs.iter().map(|costs| {
        let likelihoods = costs.iter().map(|cost| (0.5 * (least - cost)).exp());
        likelihoods.sum::<f64>()
    });
    let places = candidates.iter().map(|candidate| candidate.centre_mm);
    let likely: Vec<(PointMm, f64)> = places
        .zip(likelihoods)
        .filter(|place| place.1 > 1e-9)
        .collect();
    least_mean_distance(&likely)
}

#[test]
fn no_method_places_a_faint_finger_within_0_8_mm_in_one_frame() {
    let pad = lattice::pad();
    let table = cache::load_or_solve(&pad, &|_, _| ()).expect("solvable");
    let [width, height] = pad.outline.size_mm();
    let mut candidates = Vec::new();
    for x in steps([INSET_MM, width - INSET_MM]) {
        for y in steps([INSET_MM, height - INSET_MM]) {
            for radius_mm in steps(RADII_MM) {
                let change = change(&table, [x, y], radius_mm);
                candidates.push(Candidate {
                    centre_mm: [x, y],
                    energy: dot(&change, &change),
                    change,
                });
            }
        }
    }
    // From half to twenty times: rises of 5 to 200 %, which are taken to change the readings in proportion. Larger ones are far from what
    // is read.
    let any: Vec<f64> = (0..20)
        .map(|step| 0.5 * 40_f64.powf(f64::from(step) / 19.0))
        .collect();
    let mut draw = ChaCha8Rng::seed_from_u64(21);
    let mut errors_mm = [0.0; 2];
    let is_full = std::env::var_os("GELPAD_FULL").is_some();
    let fingers = if is_full { 1000 } else { 200 };
    for _ in 0..fingers {
        let mut between =
            |low: f64, high: f64| Uniform::new(low, high).expect("a range").sample(&mut draw);
        let truth = [
            between(INSET_MM, width - INSET_MM),
            between(INSET_MM, height - INSET_MM),
        ];
        let mut read = change(&table, truth, between(RADII_MM[0], RADII_MM[1]));
        for value in &mut read {
            let noise: f64 = StandardNormal.sample(&mut draw);
            *value += noise;
        }
        let along: Vec<f64> = candidates
            .par_iter()
            .map(|candidate| dot(&read, &candidate.change))
            .collect();
        for (error_mm, rises) in errors_mm.iter_mut().zip([&[1.0][..], &any]) {
            *error_mm += apart_mm(best_place(&along, &candidates, rises), truth) / fingers as f64;
        }
    }
    let [known_mm, unknown_mm] = errors_mm;
    println!(
        "a rise of 10 %, 60 dB, one frame: {known_mm:.2} mm if the rise is known, {unknown_mm:.2} mm if it is from 5 to 200 %"
    );
    assert!(known_mm < unknown_mm);
    assert!((0.8..1.0).contains(&unknown_mm), "{unknown_mm}");
}
