//! Presses at known places tell more of a pad than its readings at rest.

use std::fmt::Write as _;
use std::sync::OnceLock;

use gelpad::eit::Press;
use gelpad::eit::identify::{
    IdentifiedPad, IdentifyError, KnownPress, KnownPresses, RestReadings, identify,
    identify_with_presses, one_by_one,
};
use gelpad::pad::{Channel, Deviations, Pad, Pair, TouchSign, cell_sites_mm};
use gelpad::source::SimulatedPad;

use crate::{built, drawing, errors, gelpad, recorded, rest};

/// A pad whose pieces differ one by one. There are more of them than independent readings at rest.
fn uneven(drawing: &Pad) -> Pad {
    let cells = cell_sites_mm(drawing).into_iter().enumerate();
    let cells = cells.map(|(index, site)| (site, 1.0 + 0.2 * libm::sin(2.4 * index as f64)));
    drawing.with_deviations(Deviations::new(cells.collect(), Vec::new()))
}

/// Presses on a grid of 18 mm by one hand. `told` says where a press is said to be: gets its number and its place.
fn presses(pad: &Pad, told: impl Fn(usize, [f64; 2]) -> [f64; 2]) -> Vec<KnownPress> {
    let simulated = SimulatedPad::new(pad).expect("solvable");
    let rest = simulated.volts(&[]).expect("solved");
    let places = (0..5).flat_map(|i| (0..5).map(move |j| [i, j].map(|k| 14.0 + 18.0 * k as f64)));
    let press = |(index, place_mm): (usize, [f64; 2])| {
        let finger = Press {
            centre_mm: place_mm,
            radius_mm: 7.0 + 0.5 * libm::sin(index as f64),
            rise: 1.0 + 0.3 * libm::cos(2.0 * index as f64),
        };
        let volts = simulated.volts(&[finger]).expect("solved");
        let pairs = volts.iter().zip(&rest);
        KnownPress {
            place_mm: told(index, place_mm),
            changes: pairs.map(|(volt, rest)| volt / rest - 1.0).collect(),
        }
    };
    places.enumerate().map(press).collect()
}

/// What most tests press: the drawing, an uneven pad made after it, its readings at rest, exact presses, and how far off the pad is that
/// the readings at rest alone give.
struct Bench {
    drawing: Pad,
    truth: Pad,
    volts: Vec<f64>,
    presses: Vec<KnownPress>,
    error_at_rest: f64,
}

/// Solved once for all tests.
fn bench() -> &'static Bench {
    static BENCH: OnceLock<Bench> = OnceLock::new();
    BENCH.get_or_init(|| {
        let drawing = drawing("edinburgh-lattice");
        let truth = uneven(&drawing);
        let volts = rest(&truth);
        Bench {
            error_at_rest: error_at_rest(&drawing, &truth, &volts),
            presses: presses(&truth, |_, place| place),
            volts,
            truth,
            drawing,
        }
    })
}

fn error_at_rest(drawing: &Pad, truth: &Pad, volts: &[f64]) -> f64 {
    let alone = identify(drawing, volts, &vec![1e-4; volts.len()], &one_by_one).expect("found");
    errors(&alone.pad, truth)[0]
}

fn with_presses(
    drawing: &Pad,
    volts: &[f64],
    presses: &[KnownPress],
) -> Result<IdentifiedPad, IdentifyError> {
    let deviations = vec![1e-4; volts.len()];
    let rest = RestReadings {
        volts,
        deviations: &deviations,
    };
    let known = KnownPresses {
        presses,
        noise: 1e-4,
    };
    identify_with_presses(drawing, rest, known, &one_by_one)
}

#[test]
fn presses_tell_what_the_untouched_pad_leaves_open() {
    let bench = bench();
    let alone = bench.error_at_rest;
    // A hand that is 1 mm beside the places, in all directions.
    let beside = |index: usize, [x, y]: [f64; 2]| {
        let angle = 2.4 * index as f64;
        [x + libm::cos(angle), y + libm::sin(angle)]
    };
    let beside = presses(&bench.truth, beside);
    for (name, presses, share) in [("exact", &bench.presses, 0.5), ("beside", &beside, 0.7)] {
        let found = with_presses(&bench.drawing, &bench.volts, presses).expect("found");
        let [cells, _] = errors(&found.pad, &bench.truth);
        println!("{name}: {cells:.4} of {alone:.4}");
        assert!(cells < share * alone, "{name}: {cells} of {alone}");
        assert!(found.unexplained.is_empty(), "{:?}", found.unexplained);
        assert!(found.misfit[1] < 0.003, "{:?}", found.misfit);
    }
}

#[test]
fn presses_at_other_places_are_left_out_and_those_of_another_pad_refused() {
    let bench = bench();
    let mut one_wrong = bench.presses.clone();
    one_wrong[6].place_mm[0] += 50.0;
    one_wrong[6].place_mm[1] += 30.0;
    let found = with_presses(&bench.drawing, &bench.volts, &one_wrong).expect("found");
    assert_eq!(found.unexplained, [6]);
    let mut mirrored = bench.presses.clone();
    for (index, press) in mirrored.iter_mut().enumerate() {
        let [x, y] = press.place_mm;
        press.place_mm = [100.0 - y, x + 0.01 * index as f64];
    }
    let error = with_presses(&bench.drawing, &bench.volts, &mirrored).expect_err("other places");
    assert!(
        matches!(error, IdentifyError::OtherPresses { .. }),
        "{error}"
    );
    assert!(error.to_string().contains("bottom-left"), "{error}");
}

#[test]
fn presses_that_lower_the_conductivity_tell_as_much() {
    let drawing = drawing("edinburgh-lattice");
    let truth = Pad {
        touch_sign: TouchSign::Fall,
        ..uneven(&drawing)
    };
    let volts = rest(&truth);
    let alone = error_at_rest(&drawing, &truth, &volts);
    let found = with_presses(&drawing, &volts, &presses(&truth, |_, place| place)).expect("found");
    let [cells, _] = errors(&found.pad, &truth);
    println!("{cells:.4} of {alone:.4}");
    assert!(cells < 0.6 * alone, "{cells} of {alone}");
    assert!(found.unexplained.is_empty(), "{:?}", found.unexplained);
}

#[test]
fn presses_tell_of_the_pad_without_the_channels_of_a_lost_electrode() {
    let bench = bench();
    let alone = bench.error_at_rest;
    let (mut volts, mut known) = (bench.volts.clone(), bench.presses.clone());
    let lost = Pair(5, 5);
    for (channel, Channel { drive, measure }) in bench.drawing.protocol.channels.iter().enumerate()
    {
        if !drive.shares_electrode(lost) && !measure.shares_electrode(lost) {
            continue;
        }
        volts[channel] = f64::NAN;
        for press in &mut known {
            press.changes[channel] = f64::NAN;
        }
    }
    let found = with_presses(&bench.drawing, &volts, &known).expect("found");
    let [cells, _] = errors(&found.pad, &bench.truth);
    println!("{cells:.4} of {alone:.4}");
    assert!(cells < 0.7 * alone, "{cells} of {alone}");
    assert!(found.unexplained.is_empty(), "{:?}", found.unexplained);
}

#[test]
fn a_press_of_two_fingers_or_of_none_is_left_out() {
    let bench = bench();
    let mut known = bench.presses.clone();
    let simulated = SimulatedPad::new(&bench.truth).expect("solvable");
    let fingers = [[30.0, 30.0], [70.0, 70.0]].map(|centre_mm| Press {
        centre_mm,
        radius_mm: 7.0,
        rise: 1.0,
    });
    let pairs = simulated.volts(&fingers).expect("solved");
    known[3].changes = pairs
        .iter()
        .zip(&bench.volts)
        .map(|(v, rest)| v / rest - 1.0)
        .collect();
    known[8].changes.fill(0.0);
    known[9].changes.fill(f64::NAN);
    let found = with_presses(&bench.drawing, &bench.volts, &known).expect("found");
    assert_eq!(found.unexplained, [3, 8, 9]);
}

#[test]
fn the_command_takes_presses_with_a_row_of_the_untouched_pad() {
    let folder = tempfile::tempdir().expect("a folder");
    let Bench { volts, presses, .. } = bench();
    std::fs::write(folder.path().join("rest.csv"), recorded(volts)).expect("written");
    let head = (0..volts.len()).map(|channel| format!(",d{channel}"));
    let mut file = format!("x_mm,y_mm{}\n", head.collect::<String>());
    for KnownPress { place_mm, changes } in presses {
        let [x, y] = place_mm;
        let differences = changes
            .iter()
            .zip(volts)
            .map(|(d, v)| format!(",{}", d * v));
        let _ = writeln!(file, "{x},{y}{}", differences.collect::<String>());
    }
    let presses_csv = folder.path().join("presses.csv");
    std::fs::write(&presses_csv, &file).expect("written");
    let command = [
        "pad",
        "identify",
        "--source",
        "replay:rest.csv",
        "--presses",
        "presses.csv",
    ];
    let (is_done, said) = gelpad(folder.path(), &command);
    assert!(!is_done && said.contains("row without a place"), "{said}");
    let untouched: Vec<String> = volts.iter().map(|volt| format!(",{volt}")).collect();
    file.push_str(&format!(",{}\n", untouched.concat()));
    std::fs::write(&presses_csv, &file).expect("written");
    let (is_done, said) = gelpad(folder.path(), &command);
    assert!(
        is_done && said.contains("presses      25, all explained"),
        "{said}"
    );
}

#[test]
fn presses_of_another_pad_of_the_same_kind_are_refused() {
    let bench = bench();
    let of_another = presses(&built(&bench.drawing), |_, place| place);
    let error = with_presses(&bench.drawing, &bench.volts, &of_another).expect_err("another pad");
    assert!(
        matches!(error, IdentifyError::Contradicted { .. }),
        "{error}"
    );
    assert!(error.to_string().contains("presses again"), "{error}");
}
