//! A pad is found from its own readings at rest: conductance and electrodes.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use gelpad::cache;
use gelpad::eit::identify::{IdentifyError, identify, one_by_one};
use gelpad::pad::{Deviations, ElectrodeDeviation, Pad, cell_sites_mm, shipped_pad};
use gelpad::source::{Noise, SimulatedPad};

mod identify {
    mod guided;
    mod in_play;
    mod presses;
}

fn drawing(name: &str) -> Pad {
    Pad::from_toml(name, shipped_pad(name).expect("shipped").toml).expect("sound")
}

/// A pad whose pieces, thickness and electrodes differ from the drawing.
fn built(drawing: &Pad) -> Pad {
    let cells = cell_sites_mm(drawing)
        .into_iter()
        .enumerate()
        .map(|(index, [x, y])| {
            let piece = 0.06 * libm::sin(2.4 * index as f64);
            let smooth = 0.15 * (libm::sin(x / 25.0) + libm::cos(y / 30.0));
            ([x, y], libm::exp(piece + smooth))
        });
    let electrodes = (0..drawing.electrodes.len()).map(|index| ElectrodeDeviation {
        shift_mm: 0.5 * libm::sin(1.7 * index as f64),
        stretch_mm: 0.0,
    });
    drawing.with_deviations(Deviations::new(cells.collect(), electrodes.collect()))
}

fn rest(pad: &Pad) -> Vec<f64> {
    let simulated = SimulatedPad::new(pad).expect("solvable");
    simulated.volts(&[]).expect("solved")
}

/// Root mean square error of the logarithm of the conductance, which has no common factor, and of the electrodes' places, mm.
fn errors(found: &Pad, truth: &Pad) -> [f64; 2] {
    let pairs = found.deviations.cells.iter().zip(&truth.deviations.cells);
    let off: Vec<f64> = pairs.map(|(a, b)| libm::log(a.1 / b.1)).collect();
    let common = off.iter().sum::<f64>() / off.len() as f64;
    let electrodes = found.electrodes.iter().zip(&truth.electrodes);
    let centre = |e: &gelpad::pad::Electrode| e.start_mm + e.width_mm / 2.0;
    let shifts: Vec<f64> = electrodes.map(|(a, b)| centre(a) - centre(b)).collect();
    let rms = |list: &[f64], middle: f64| {
        let sum: f64 = list
            .iter()
            .map(|value| (value - middle) * (value - middle))
            .sum();
        libm::sqrt(sum / list.len() as f64)
    };
    [rms(&off, common), rms(&shifts, 0.0)]
}

#[test]
fn conductance_and_electrodes_are_found_on_another_mesh_and_in_any_unit() {
    let drawing = drawing("edinburgh-lattice");
    let truth = built(&drawing);
    let even = truth.deviations.cells.iter().map(|(site, _)| (*site, 1.0));
    let as_drawn = drawing.with_deviations(Deviations::new(even.collect(), Vec::new()));
    let [cells_drawn, shifts_drawn] = errors(&as_drawn, &truth);
    let volts: Vec<f64> = rest(&truth).iter().map(|volt| 3.7e4 * volt).collect();
    let found = identify(&drawing, &volts, &vec![1e-4; volts.len()], &one_by_one).expect("found");
    let [cells, shifts] = errors(&found.pad, &truth);
    assert!(
        found.misfit[0] > 0.05 && found.misfit[1] < 0.002,
        "{:?}",
        found.misfit
    );
    assert!(cells < 0.5 * cells_drawn, "{cells} of {cells_drawn}");
    assert!(shifts < 0.6 * shifts_drawn, "{shifts} of {shifts_drawn} mm");
}

#[test]
fn a_pad_as_drawn_stays_as_drawn_whatever_readings_are_lost() {
    let drawing = drawing("edinburgh-lattice");
    let mut volts = rest(&drawing);
    volts[3] = f64::NAN;
    volts[50] = 0.0;
    let mut deviations = vec![1e-4; volts.len()];
    deviations[7] = f64::INFINITY;
    let found = identify(&drawing, &volts, &deviations, &one_by_one).expect("found");
    for (site, factor) in &found.pad.deviations.cells {
        assert!((factor - 1.0).abs() < 0.02, "{site:?}: {factor}");
    }
    for electrode in &found.pad.deviations.electrodes {
        assert!(electrode.shift_mm.abs() < 0.05, "{electrode:?}");
    }
}

#[test]
fn readings_of_another_pad_are_refused() {
    let lattice = drawing("edinburgh-lattice");
    let deviations = vec![1e-4; lattice.channels()];
    // Wires in another order.
    let mut shuffled = rest(&lattice);
    shuffled.rotate_left(13 * 5 + 4);
    let error = identify(&lattice, &shuffled, &deviations, &one_by_one).expect_err("another order");
    assert!(matches!(error, IdentifyError::OtherPad { .. }), "{error}");
    assert!(error.to_string().contains("wired in order"), "{error}");
    // A stuck board.
    let equal = vec![1.0; lattice.channels()];
    let error = identify(&lattice, &equal, &deviations, &one_by_one).expect_err("equal readings");
    assert!(matches!(error, IdentifyError::Uneven { .. }), "{error}");
    assert!(error.to_string().contains("stuck"), "{error}");
    let nothing = vec![0.0; lattice.channels()];
    let error = identify(&lattice, &nothing, &deviations, &one_by_one).expect_err("no reading");
    assert!(
        matches!(error, IdentifyError::TooFew { usable: 0, .. }),
        "{error}"
    );
}

/// A recording of twenty frames with these readings, in noise.
fn recorded(volts: &[f64]) -> String {
    let mut noise = Noise::new(60.0, 5);
    let head = (0..volts.len()).map(|channel| format!(",v{channel}"));
    let mut csv = format!("t_ms{}\n", head.collect::<String>());
    for frame in 0..20 {
        let _ = write!(csv, "{}", 10 * frame);
        for volt in noise.read(volts) {
            let _ = write!(csv, ",{volt}");
        }
        csv.push('\n');
    }
    csv
}

/// `gelpad` in a folder, with the tables in the folder's `cache`.
fn gelpad(folder: &Path, arguments: &[&str]) -> (bool, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .current_dir(folder)
        .args(arguments)
        .env(cache::FOLDER_VARIABLE, folder.join("cache"))
        .output()
        .expect("started");
    let said = [output.stdout, output.stderr].concat();
    (
        output.status.success(),
        String::from_utf8_lossy(&said).into_owned(),
    )
}

#[test]
fn the_command_writes_a_pad_that_has_these_readings() {
    let folder = tempfile::tempdir().expect("a folder");
    let drawing = drawing("edinburgh-lattice");
    let truth = built(&drawing);
    let volts = rest(&truth);
    std::fs::write(folder.path().join("rest.csv"), recorded(&volts)).expect("written");

    let identify = [
        "pad",
        "identify",
        "--source",
        "replay:rest.csv",
        "-o",
        "found.toml",
        "--map",
        "found.png",
    ];
    let (is_done, said) = gelpad(folder.path(), &identify);
    assert!(is_done, "{said}");
    assert!(said.contains("--pad ./found.toml"), "{said}");
    let text = std::fs::read_to_string(folder.path().join("found.toml")).expect("a pad");
    let found = Pad::from_toml("found.toml", &text).expect("sound");
    let [cells, shifts] = errors(&found, &truth);
    assert!(cells < 0.08 && shifts < 0.3, "{cells} {shifts}");
    // What is found again on the found pad is the same: the drawing is in the text.
    assert_eq!(
        found.drawing(),
        Pad {
            name: found.name.clone(),
            ..drawing
        }
    );
    let png = std::fs::read(folder.path().join("found.png")).expect("a map");
    assert!(png.starts_with(b"\x89PNG"));

    let (is_done, said) = gelpad(folder.path(), &identify);
    assert!(!is_done && said.contains("found.toml exists"), "{said}");
    let (is_done, said) = gelpad(folder.path(), &["pad", "check", "./found.toml"]);
    assert!(is_done, "{said}");
    // The simulated pad, by default.
    let (is_done, said) = gelpad(folder.path(), &["pad", "identify"]);
    assert!(is_done && said.contains("electrodes "), "{said}");
}
