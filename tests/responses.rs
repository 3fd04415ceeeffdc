//! The table of responses against the forward model that it stands for: random touches, solved in full on the fine mesh.

mod lattice;

use gelpad::cache;
use gelpad::eit::response::{Response, Shape, TouchModel, strength_from_rise};
use gelpad::eit::{ContactModel, ForwardModel, Mesh, MeshSize};
use gelpad::eit::{Press, ResponseBuilder, ResponseTable};
use gelpad::pad::{Pad, TouchSign, shipped_pad};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Uniform};

/// Relative errors of the table's responses, ascending.
fn errors(pad: &Pad, sign: TouchSign, touches: usize) -> Vec<f64> {
    let table = cache::load_or_solve(pad, &|_, _| ()).expect("solvable");
    let mesh = Mesh::from_pad(pad, MeshSize::reconstruction(pad));
    let model = ForwardModel::new(mesh, &ContactModel::from_pad(pad)).expect("solvable");
    let background = pad.background_s_per_m;
    let untouched = model
        .solve_even(background)
        .expect("solvable")
        .voltages(&pad.protocol);
    let mut draw = ChaCha8Rng::seed_from_u64(1);
    let mut between =
        |low: f64, high: f64| Uniform::new(low, high).expect("a range").sample(&mut draw);
    let [width, height] = pad.outline.size_mm();
    let (mut response, mut told) = (Response::default(), vec![0.0; pad.channels()]);
    let mut errors = Vec::new();
    while errors.len() < touches {
        let press = Press {
            centre_mm: [between(0.08, 0.92) * width, between(0.08, 0.92) * height],
            radius_mm: between(5.0, 9.0),
            rise: between(0.5, 2.0),
        };
        if !pad.outline.contains(press.centre_mm) {
            continue;
        }
        let conductivity = model.mesh().mean_over_triangles(|point| {
            let factor = 1.0 + press.rise * press.rise_share(point);
            match sign {
                TouchSign::Rise => background * factor,
                TouchSign::Fall => background / factor,
            }
        });
        let touched = model
            .solve(&conductivity)
            .expect("solvable")
            .voltages(&pad.protocol);
        let bump = TouchModel {
            centre_mm: press.centre_mm,
            log_radius: press.radius_mm.ln(),
            strength: strength_from_rise(press.rise),
            sign,
            shape: Shape::Round,
        };
        table.respond(&bump, &mut response);
        table.expand(&response.value, &mut told);
        let (mut off, mut all) = (0.0, 0.0);
        for (channel, told) in told.iter().enumerate() {
            let true_change = touched[channel] / untouched[channel] - 1.0;
            off += (f64::from(*told) - true_change).powi(2);
            all += true_change.powi(2);
        }
        errors.push((off / all).sqrt());
    }
    errors.sort_by(f64::total_cmp);
    println!(
        "{} {sign:?}: rank {}, error median {:.2} %, p95 {:.2} %",
        pad.name,
        table.rank(),
        100.0 * errors[touches / 2],
        100.0 * errors[touches * 95 / 100]
    );
    errors
}

#[test]
fn the_table_of_the_lattice_is_within_a_few_per_cent_of_the_forward_model() {
    for sign in [TouchSign::Rise, TouchSign::Fall] {
        let errors = errors(&lattice::pad(), sign, 60);
        assert!(errors[30] < 0.02 && errors[57] < 0.10);
    }
}

/// A table holds an eighth of its places; the others follow when it is read, to the same bits.
#[test]
fn a_table_that_is_read_again_is_the_same() {
    let pad = lattice::pad();
    let table = cache::solve(&pad, &|_, _| ()).expect("solvable");
    let bytes = table.to_bytes();
    assert!(bytes.len() < 7 << 20, "{} bytes", bytes.len());
    assert_eq!(ResponseTable::from_bytes(&bytes, &pad), Ok(table));
}

#[test]
fn so_is_that_of_a_pad_whose_touches_conduct_worse_and_are_read_otherwise() {
    let shipped = shipped_pad("openeit-lattice").expect("shipped");
    let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
    let errors = errors(&pad, TouchSign::Fall, 40);
    assert!(errors[20] < 0.03 && errors[38] < 0.12);
}

/// So that a table does not depend on the number of cores, nor on which of them is faster.
#[test]
fn the_rows_of_a_table_may_be_solved_in_any_order() {
    let text = include_str!("data/recordings/strip-pad.toml");
    let pad = Pad::from_toml("strip", text).expect("sound");
    let builder = ResponseBuilder::new(&pad).expect("solvable");
    let mut rows: Vec<_> = (0..builder.rows())
        .rev()
        .map(|row| builder.solve_row(row))
        .collect();
    rows.reverse();
    let table = cache::solve(&pad, &|_, _| ()).expect("solvable");
    assert_eq!(builder.finish(&rows), table);
}
