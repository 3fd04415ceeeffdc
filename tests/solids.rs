//! Three-dimensional models against known solutions: the two-dimensional sheet, Ohm's law, beams and punches.

use gelpad::eit::{ContactModel, ForwardModel, Mesh, MeshSize};
use gelpad::pad::{Pad, shipped_pad};
use gelpad::study::solid::{
    Bricks, Constraint, Contact, CurrentModel, Elastic, Lines, Rubber, growing_lines,
};
use gelpad::study::thickness::{Placement, conductor, under_indenter};

fn lattice() -> Pad {
    let shipped = shipped_pad("edinburgh-lattice").expect("shipped");
    Pad::from_toml(shipped.name, shipped.toml).expect("sound")
}

fn even(from: f64, to: f64, cells: usize) -> Vec<f64> {
    (0..=cells)
        .map(|line| from + (to - from) * line as f64 / cells as f64)
        .collect()
}

/// Mean relative difference.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| ((a - b) / b).abs()).sum();
    sum / a.len() as f64
}

fn volts_of(pad: &Pad, layer_mm: f64, size: MeshSize, placement: Placement) -> Vec<f64> {
    let model = conductor(pad, layer_mm, size, 2, placement).expect("solvable");
    let even = vec![pad.background_s_per_m; model.bricks().corners.len()];
    model
        .solve(&model.bricks().nodes_mm, &even)
        .expect("solved")
        .voltages(&pad.protocol)
}

#[test]
fn a_thin_layer_is_the_sheet_over_its_thickness() {
    let pad = lattice();
    let layer_mm = 0.5;
    let size = MeshSize::relative(&pad, 0.8, false);
    let contacts = ContactModel {
        thickness_m: layer_mm * 1e-3,
        ..ContactModel::from_pad(&pad)
    };
    let sheet = ForwardModel::new(Mesh::from_pad(&pad, size), &contacts).expect("solvable");
    let sheet = sheet.solve_even(pad.background_s_per_m).expect("solved");
    let off = apart(
        &volts_of(&pad, layer_mm, size, Placement::Side),
        &sheet.voltages(&pad.protocol),
    );
    println!("thin layer against sheet: {:.2} %", 100.0 * off);
    assert!(off < 0.01, "{off}");
}

#[test]
fn readings_are_reciprocal_and_converge() {
    let pad = lattice();
    let volts: Vec<Vec<f64>> = [2.4, 1.2, 0.6]
        .map(|scale| {
            volts_of(
                &pad,
                2.0,
                MeshSize::relative(&pad, scale, false),
                Placement::Underside,
            )
        })
        .into();
    let twins = pad.protocol.reciprocal();
    for (volt, twin) in volts[2].iter().zip(&twins) {
        let twin = volts[2][twin.expect("every channel has a twin")];
        assert!(((volt - twin) / volt).abs() < 1e-8, "{volt} {twin}");
    }
    let (coarse, fine) = (apart(&volts[0], &volts[1]), apart(&volts[1], &volts[2]));
    let order = (coarse / fine).log2();
    println!(
        "refined twice: {:.3} %, {:.3} %: order {order:.2}",
        100.0 * coarse,
        100.0 * fine
    );
    assert!(order > 0.8, "order {order}: {coarse} {fine}");
}

/// A bar along x whose ends carry current and whose voltage is read between two rings of its surface.
fn bar(length_mm: f64) -> Bricks {
    let across = even(0.0, 2.0, 4);
    let lines = Lines([even(0.0, length_mm, 40), across.clone(), across]);
    Bricks::new(lines, |_| true)
}

#[test]
fn a_stretched_bar_has_the_square_of_its_stretch_in_resistance() {
    let length = 20.0;
    let bricks = bar(length);
    let face = |bricks: &Bricks, line: usize| -> Vec<[usize; 4]> {
        let node = |j, k| bricks.node([line, j, k]).expect("full");
        (0..4)
            .flat_map(|j| (0..4).map(move |k| (j, k)))
            .map(|(j, k)| {
                [
                    node(j, k),
                    node(j + 1, k),
                    node(j + 1, k + 1),
                    node(j, k + 1),
                ]
            })
            .collect()
    };
    // Current flows between the ends; the voltage is read at a quarter and three quarters, on the underside.
    let probe = |bricks: &Bricks, line: usize| -> Vec<[usize; 4]> {
        let node = |i, j| bricks.node([i, j, 0]).expect("full");
        vec![[
            node(line, 0),
            node(line + 1, 0),
            node(line + 1, 1),
            node(line, 1),
        ]]
    };
    let contacts: Vec<Contact> = [
        face(&bricks, 0),
        probe(&bricks, 10),
        probe(&bricks, 29),
        face(&bricks, 40),
    ]
    .into_iter()
    .map(|faces| Contact {
        faces,
        impedance_ohm_m2: 1e-5,
    })
    .collect();
    // The probes draw no current: it flows from the first electrode to the last, which is ground.
    let model = CurrentModel::new(bricks.clone(), contacts).expect("solvable");
    let even = vec![1.0; bricks.corners.len()];
    let resistance = |places: &[[f64; 3]]| {
        let transfer = model.solve(places, &even).expect("solved");
        transfer.ohm(0, 1) - transfer.ohm(0, 2)
    };
    let at_rest = resistance(&bricks.nodes_mm);
    for stretch in [1.1, 1.3, 1.6] {
        let ends = bricks
            .nodes_mm
            .iter()
            .enumerate()
            .filter_map(|(node, [x, ..])| {
                let by_mm = match *x {
                    x if x < 1e-9 => 0.0,
                    x if x > length - 1e-9 => (stretch - 1.0) * length,
                    _ => return None,
                };
                Some(Constraint {
                    node,
                    axis: 0,
                    by_mm,
                })
            });
        let sides = bricks
            .nodes_mm
            .iter()
            .enumerate()
            .flat_map(|(node, place)| {
                [1, 2]
                    .into_iter()
                    .filter(|axis| place[*axis] < 1e-9)
                    .map(move |axis| Constraint {
                        node,
                        axis,
                        by_mm: 0.0,
                    })
            });
        let rubbers = vec![Rubber::from_young(20.0, 0.4999); bricks.corners.len()];
        let mut body =
            Elastic::new(bricks.clone(), rubbers, ends.chain(sides).collect(), 0.25).expect("held");
        body.load_to(1.0).expect("stretched");
        let places: Vec<[f64; 3]> = bricks
            .nodes_mm
            .iter()
            .zip(body.moved_mm())
            .map(|(place, by)| std::array::from_fn(|axis| place[axis] + by[axis]))
            .collect();
        let ratio = resistance(&places) / at_rest;
        println!(
            "stretch {stretch}: R / R0 = {ratio:.4}, s^2 = {:.4}",
            stretch * stretch
        );
        assert!(
            (ratio / (stretch * stretch) - 1.0).abs() < 0.01,
            "{stretch}: {ratio}"
        );
        // On the bricks at rest with the conductivity as a tensor the result is the same.
        let turned = |place| body.gradient_at(place).expect("in the bar");
        let transfer = model
            .solve_stretched(&places, turned, &even)
            .expect("solved");
        let same = (transfer.ohm(0, 1) - transfer.ohm(0, 2)) / at_rest / ratio;
        println!("  solved at rest: {same:.6} of that");
        assert!((same - 1.0).abs() < 1e-3, "{stretch}: {same}");
    }
}

#[test]
fn an_affine_deformation_is_exact_on_distorted_bricks() {
    let mut bricks = Bricks::new(
        Lines([even(0.0, 3.0, 3), even(0.0, 3.0, 3), even(0.0, 2.0, 2)]),
        |_| true,
    );
    let inside =
        |[x, y, z]: [f64; 3]| x > 0.1 && x < 2.9 && y > 0.1 && y < 2.9 && z > 0.1 && z < 1.9;
    for (index, place) in bricks.nodes_mm.iter_mut().enumerate() {
        if inside(*place) {
            for (axis, coordinate) in place.iter_mut().enumerate() {
                *coordinate += 0.2 * (((index * 13 + axis * 7) % 9) as f64 / 9.0 - 0.5);
            }
        }
    }
    let gradient = [[0.2, 0.1, 0.0], [-0.05, -0.1, 0.08], [0.02, 0.0, 0.15]];
    let affine = |place: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|i| (0..3).map(|l| gradient[i][l] * place[l]).sum())
    };
    let prescribed = bricks
        .nodes_mm
        .iter()
        .enumerate()
        .filter(|(_, place)| !inside(**place))
        .flat_map(|(node, place)| {
            let by = affine(*place);
            (0..3).map(move |axis| Constraint {
                node,
                axis,
                by_mm: by[axis],
            })
        })
        .collect();
    let rubbers = vec![Rubber::from_young(60.0, 0.4999); bricks.corners.len()];
    let mut body = Elastic::new(bricks.clone(), rubbers, prescribed, 0.5).expect("held");
    body.load_to(1.0).expect("deformed");
    for (place, moved) in bricks.nodes_mm.iter().zip(body.moved_mm()) {
        for (moved, exact) in moved.iter().zip(affine(*place)) {
            assert!((moved - exact).abs() < 1e-8, "{place:?}: {moved} {exact}");
        }
    }
}

#[test]
fn a_nearly_incompressible_beam_agrees_with_theory() {
    // A cantilever of 20 x 2 x 1 mm, its end displaced by a hundredth of its length: F = 3 E I w / L^3, corrected for shear.
    let (length, width, height) = (20.0, 2.0, 1.0);
    let young = 60.0;
    let bricks = Bricks::new(
        Lines([
            even(0.0, length, 80),
            even(0.0, width, 4),
            even(0.0, height, 4),
        ]),
        |_| true,
    );
    let tip_mm = 0.01 * length;
    let clamped = bricks
        .nodes_mm
        .iter()
        .enumerate()
        .filter(|(_, [x, ..])| *x < 1e-9)
        .flat_map(|(node, [_, y, z])| {
            // The root cannot warp, but may become narrower.
            let mut axes = vec![0];
            if *y < 1e-9 {
                axes.push(1);
            }
            if *z < 1e-9 {
                axes.push(2);
            }
            axes.into_iter().map(move |axis| Constraint {
                node,
                axis,
                by_mm: 0.0,
            })
        });
    let tip: Vec<usize> = (0..bricks.nodes_mm.len())
        .filter(|node| bricks.nodes_mm[*node][0] > length - 1e-9)
        .collect();
    let pushed = tip.iter().map(|node| Constraint {
        node: *node,
        axis: 2,
        by_mm: tip_mm,
    });
    let rubbers = vec![Rubber::from_young(young, 0.4999); bricks.corners.len()];
    let mut body = Elastic::new(
        bricks.clone(),
        rubbers,
        clamped.chain(pushed).collect(),
        1.0,
    )
    .expect("held");
    body.load_to(1.0).expect("bent");
    let force_n = body.holding_force_n(&tip)[2];
    let inertia = width * height.powi(3) / 12.0;
    // Timoshenko's beam, with the shear coefficient 5/6.
    let shear =
        3.0 * young * inertia / (5.0 / 6.0 * young / 3.0 * width * height * length * length);
    let theory_n = 3.0 * young * inertia * tip_mm / length.powi(3) / (1.0 + shear) * 1e-3;
    println!(
        "beam: {:.4} mN, theory {:.4} mN",
        force_n * 1e3,
        theory_n * 1e3
    );
    assert!(
        (force_n / theory_n - 1.0).abs() < 0.05,
        "{force_n} {theory_n}"
    );
}

#[test]
fn a_flat_punch_agrees_with_theory() {
    // A quarter of a block twenty radii wide and deep; a frictionless punch: F = 2 E a d / (1 - nu^2) (Sneddon 1965).
    let (radius, depth, size) = (5.0, 0.1, 100.0);
    let (young, poisson) = (60.0, 0.4999);
    let half: Vec<f64> = growing_lines([-size, size], 0.0, 6.5, [0.5, 30.0], 1.4)
        .into_iter()
        .filter(|line| *line > 0.0)
        .collect();
    let across: Vec<f64> = std::iter::once(0.0).chain(half.clone()).collect();
    let z: Vec<f64> = across.iter().rev().map(|line| -line).collect();
    let bricks = Bricks::new(Lines([across.clone(), across, z]), |_| true);
    // Half the radius is a quarter of the surface.
    let held = under_indenter(&bricks, [0.0, 0.0], radius / 2.0);
    let punch = held.iter().map(|node| Constraint {
        node: *node,
        axis: 2,
        by_mm: -depth,
    });
    let still = bricks
        .nodes_mm
        .iter()
        .enumerate()
        .flat_map(|(node, [x, y, z])| {
            let floor = *z < 1e-9 - size;
            let axes = [floor || *x < 1e-9, floor || *y < 1e-9, floor];
            (0..3)
                .filter(move |axis| axes[*axis])
                .map(move |axis| Constraint {
                    node,
                    axis,
                    by_mm: 0.0,
                })
        });
    let rubbers = vec![Rubber::from_young(young, poisson); bricks.corners.len()];
    let mut body =
        Elastic::new(bricks.clone(), rubbers, punch.chain(still).collect(), 1.0).expect("held");
    body.load_to(1.0).expect("pressed");
    let force_n = 4.0 * -body.holding_force_n(&held)[2];
    let theory_n = 2.0 * young * radius * depth / (1.0 - poisson * poisson) * 1e-3;
    println!("punch: {force_n:.5} N, theory {theory_n:.5} N");
    assert!(
        (force_n / theory_n - 1.0).abs() < 0.05,
        "{force_n} {theory_n}"
    );
}

#[test]
fn an_arch_that_snaps_through_comes_to_rest() {
    // A clamped shallow arch of 40 x 2 x 1 mm, 3 mm high, pressed through a soft post of 20 mm: the top of the post is displaced,
    // but the arch is free to snap, and between its two states there is no equilibrium.
    let (half, rise, post_mm) = (20.0, 3.0, 20.0);
    let mut z = even(0.0, 1.0, 2);
    z.extend(even(1.0, 1.0 + post_mm, 10).into_iter().skip(1));
    let lines = Lines([even(-half, half, 40), even(0.0, 2.0, 1), z]);
    let mut bricks = Bricks::new(lines, |[i, _, k]| k < 2 || i == 19 || i == 20);
    for [x, _, z] in &mut bricks.nodes_mm {
        *z += rise * (1.0 + (std::f64::consts::PI * *x / half).cos()) / 2.0;
    }
    let top = 1.0 + rise + post_mm - 0.2;
    let mut constraints = Vec::new();
    for (node, [x, _, z]) in bricks.nodes_mm.iter().enumerate() {
        let (held, pushed) = (x.abs() > half - 1e-9, *z > top);
        for axis in 0..3 {
            // Nothing moves sideways: a plane problem.
            if axis == 1 || held || pushed {
                let by_mm = if pushed && axis == 2 { -12.0 } else { 0.0 };
                constraints.push(Constraint { node, axis, by_mm });
            }
        }
    }
    let rubbers = bricks
        .cells
        .iter()
        .map(|[.., k]| Rubber::from_young(if *k < 2 { 100.0 } else { 0.5 }, 0.3))
        .collect();
    let middle = bricks
        .nodes_mm
        .iter()
        .position(|[x, y, z]| x.abs() < 1e-9 && *y < 1e-9 && (z - rise).abs() < 1e-9)
        .expect("a node under the middle");
    let mut body = Elastic::new(bricks, rubbers, constraints, 0.1).expect("held");
    let mut sunk = Vec::new();
    for step in 1..=24 {
        body.load_to(f64::from(step) / 24.0).expect("at rest");
        sunk.push(-body.moved_mm()[middle][2]);
    }
    println!("the arch's middle has sunk by {sunk:.2?} mm");
    let steps = sunk.windows(2).map(|pair| pair[1] - pair[0]);
    let longest = steps.fold(0.0, f64::max);
    assert!(longest > rise, "it does not snap: {sunk:.2?}");
    assert!(sunk[23] > 2.0 * rise, "{sunk:.2?}");
}
