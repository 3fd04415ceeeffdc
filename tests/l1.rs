//! L1's answers against plain accelerated iterations (FISTA) from zero in f64, frame by frame of the session.
//!
//! Every 30th frame by default; all 3000 with `GELPAD_FULL=1` (a few minutes in a release build).

use std::path::PathBuf;

use gelpad::eit::reconstruct::l1::{ITERATIONS, L1Model, L1State};
use gelpad::eit::{LAMBDA, Linearised, REFERENCE_FRAMES, Reference};
use gelpad::pad::{DEFAULT_PAD, Pad, shipped_pad};

fn session() -> Vec<Vec<f32>> {
    let path =
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/lattice-presses/session.csv");
    csv::Reader::from_path(path)
        .expect("session.csv")
        .deserialize()
        .map(|row| {
            let row: Vec<f32> = row.expect("numbers");
            row[1..].to_vec()
        })
        .collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// A x - dv.
fn residual(model: &L1Model, x: &[f64], changes: &[f64]) -> Vec<f64> {
    let mut residual: Vec<f64> = changes.iter().map(|change| -change).collect();
    for (pixel, value) in x.iter().enumerate() {
        if *value != 0.0 {
            for (r, a) in residual.iter_mut().zip(model.column(pixel)) {
                *r += value * a;
            }
        }
    }
    residual
}

fn objective(model: &L1Model, x: &[f64], changes: &[f64], lambda: f64) -> f64 {
    let r = residual(model, x, changes);
    0.5 * dot(&r, &r) + lambda * x.iter().map(|x| x.abs()).sum::<f64>()
}

#[test]
fn no_frame_of_the_session_is_worse_than_after_200_accelerated_iterations() {
    let full = std::env::var_os("GELPAD_FULL").is_some();
    let pad = shipped_pad(DEFAULT_PAD).expect("shipped");
    let pad = Pad::from_toml(pad.name, pad.toml).expect("sound");
    let model = L1Model::new(
        &Linearised::from_pad(&pad).expect("solvable").jacobian,
        LAMBDA,
        true,
    );
    let mut reference = Reference::new(model.channels());
    let (mut state, mut changes) = (L1State::default(), vec![0.0f32; model.channels()]);
    let (mut compared, mut worst, mut most_sweeps) = (0, f64::NEG_INFINITY, 0);
    for (index, volts) in session().iter().enumerate() {
        if index < REFERENCE_FRAMES {
            reference.add_first_frame(index as u64 * 10_000_000, volts);
            continue;
        }
        reference.relative_changes(volts, &mut changes);
        let changes: Vec<f64> = changes.iter().map(|change| f64::from(*change)).collect();
        let quality = model.solve(&changes, reference.change_noise(), &mut state);
        most_sweeps = most_sweeps.max(quality.sweeps);
        if !full && index % 30 != 0 {
            continue;
        }
        let plain = model.solve_fista(&changes, quality.lambda_abs, ITERATIONS);
        let theirs = objective(&model, &plain, &changes, quality.lambda_abs);
        let ours = objective(&model, state.answer(), &changes, quality.lambda_abs);
        assert!(
            (ours - quality.objective).abs() <= 1e-9 * ours.max(1e-12),
            "the reported objective is the true one"
        );
        compared += 1;
        worst = worst.max((ours - theirs) / theirs);
        assert!(ours <= theirs, "frame {index}: {ours:e} against {theirs:e}");
    }
    println!(
        "{compared} frames: ours/theirs - 1 at worst {worst:.1e}; at most {most_sweeps} sweeps"
    );
}
