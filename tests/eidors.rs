//! The forward model compared with EIDORS on the same mesh (tests/data/eidors-square-cem).

use std::fs;
use std::path::PathBuf;

use gelpad::eit::{ContactModel, ForwardModel, Mesh, element_jacobian};
use gelpad::pad::Protocol;

const TOUCH_CENTRE_MM: [f64; 2] = [70.0, 35.0];
const TOUCH_RADIUS_MM: f64 = 6.0;

fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/eidors-square-cem")
        .join(name)
}

fn table(name: &str) -> Vec<Vec<f64>> {
    csv::ReaderBuilder::new()
        .has_headers(false)
        .from_path(data(name))
        .expect(name)
        .deserialize()
        .map(|row| row.expect(name))
        .collect()
}

fn column(name: &str) -> Vec<f64> {
    table(name).concat()
}

fn indices(name: &str) -> Vec<Vec<usize>> {
    table(name)
        .into_iter()
        .map(|row| {
            row.into_iter()
                .map(|one_based| one_based as usize - 1)
                .collect()
        })
        .collect()
}

/// EIDORS' square with a contact impedance of 0.001 ohm m2, in 2-D units.
fn model() -> ForwardModel {
    let nodes_mm = table("nodes_m.csv")
        .into_iter()
        .map(|xy| [xy[0] * 1e3, xy[1] * 1e3])
        .collect();
    let triangles = indices("elems_1based.csv")
        .into_iter()
        .map(|t| [t[0], t[1], t[2]])
        .collect();
    let electrodes: Vec<Vec<[usize; 2]>> = indices("electrode_nodes_1based.csv")
        .into_iter()
        .map(|nodes| nodes.windows(2).map(|pair| [pair[0], pair[1]]).collect())
        .collect();
    let contacts = ContactModel {
        thickness_m: 1.0,
        impedance_ohm_m2: vec![1e-3; electrodes.len()],
    };
    let mesh = Mesh {
        nodes_mm,
        triangles,
        electrodes,
    };
    ForwardModel::new(mesh, &contacts).expect("a valid mesh")
}

fn adjacent() -> Protocol {
    let pairs = Protocol::pairs_with_step(16, 1);
    Protocol::from_patterns(16, &pairs, &pairs, false).expect("adjacent")
}

fn worst_relative(ours: &[f64], theirs: &[f64]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    ours.iter()
        .zip(theirs)
        .map(|(a, b)| ((a - b) / b).abs())
        .fold(0.0, f64::max)
}

#[test]
fn homogeneous_voltages_agree() {
    let volts = model()
        .solve_even(1.0)
        .expect("solved")
        .voltages(&adjacent());
    assert!(volts.iter().all(|volt| *volt > 0.0), "all 208 are positive");
    let worst = worst_relative(&volts, &column("v_homog_208.csv"));
    println!("homogeneous: worst relative difference {worst:.1e}");
    assert!(worst < 1e-6);
}

#[test]
fn voltages_of_an_insulating_disc_agree() {
    let model = model();
    let sigma: Vec<f64> = (0..model.mesh().triangles.len())
        .map(|t| {
            let [x, y] = model.mesh().centroid_mm(t);
            let distance = (x - TOUCH_CENTRE_MM[0]).hypot(y - TOUCH_CENTRE_MM[1]);
            if distance < TOUCH_RADIUS_MM { 0.5 } else { 1.0 }
        })
        .collect();
    let volts = model.solve(&sigma).expect("solved").voltages(&adjacent());
    let worst = worst_relative(&volts, &column("v_target_208.csv"));
    println!("disc: worst relative difference {worst:.1e}");
    assert!(worst < 1e-6);
}

#[test]
fn the_jacobian_agrees() {
    let model = model();
    let fields = model.solve_even(1.0).expect("solved");
    let all: Vec<usize> = (0..model.mesh().triangles.len()).collect();
    let ours = element_jacobian(&model, &fields, &adjacent(), &all);
    let theirs = npy_f32("jacobian_208x3200.npy", ours.nrows(), ours.ncols());
    let mut largest = 0.0f64;
    let mut worst = 0.0f64;
    for row in 0..ours.nrows() {
        for column in 0..ours.ncols() {
            let expected = f64::from(theirs[row * ours.ncols() + column]);
            largest = largest.max(expected.abs());
            worst = worst.max((ours[(row, column)] - expected).abs());
        }
    }
    println!(
        "Jacobian: worst difference {:.1e} of the largest entry",
        worst / largest
    );
    assert!(worst < 1e-4 * largest);
}

#[test]
fn reciprocity_holds_to_rounding() {
    let protocol = adjacent();
    let volts = model().solve_even(1.0).expect("solved").voltages(&protocol);
    let worst = protocol
        .reciprocal()
        .into_iter()
        .enumerate()
        .map(|(index, other)| {
            let other = volts[other.expect("the full set")];
            ((volts[index] - other) / other).abs()
        })
        .fold(0.0, f64::max);
    println!("reciprocity: worst relative difference {worst:.1e}");
    assert!(worst < 1e-9);
}

/// The values of a version-1 `.npy` file of little-endian f32 in C order.
fn npy_f32(name: &str, rows: usize, columns: usize) -> Vec<f32> {
    let bytes = fs::read(data(name)).expect(name);
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let about = String::from_utf8_lossy(&bytes[10..header]);
    assert!(
        about.contains("'<f4'") && about.contains("'fortran_order': False"),
        "{about}"
    );
    let values: Vec<f32> = bytes[header..]
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    assert_eq!(values.len(), rows * columns);
    values
}
