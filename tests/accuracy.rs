//! `gelpad accuracy`: the same seed gives the same files, results agree with the bound, and invalid input is rejected.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use serde_json::Value;

fn accuracy(arguments: &[&str], out: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .arg("accuracy")
        .args(arguments)
        .arg("--out")
        .arg(out)
        .stdin(Stdio::null())
        .output()
        .expect("started")
}

fn done(arguments: &[&str], out: &Path) -> String {
    let output = accuracy(arguments, out);
    let stderr = String::from_utf8(output.stderr).expect("text");
    assert!(output.status.success(), "{stderr}");
    let stdout = String::from_utf8(output.stdout).expect("text");
    assert_eq!(
        stdout.trim_end(),
        out.join("report.html").display().to_string()
    );
    stderr
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| {
            let path = entry.expect("an entry").path();
            let name = path
                .file_name()
                .expect("a name")
                .to_string_lossy()
                .into_owned();
            (name, fs::read(&path).expect("a file"))
        })
        .collect()
}

fn json(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("accuracy.json")).expect("accuracy.json"))
        .expect("JSON")
}

/// The findings of a number of touches with proportional noise of an SNR.
fn at(found: &Value, touches: u64, snr_db: f64) -> Value {
    found["touches"]
        .as_array()
        .expect("a list")
        .iter()
        .find(|one| {
            one["touches"] == touches && one["noise"] == "proportional" && one["snr_db"] == snr_db
        })
        .expect("studied")
        .clone()
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn the_same_seed_gives_the_same_files_and_snrs_are_independent() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = |name: &str| root.path().join(name);
    let played = |snrs, out| {
        let arguments = ["--quick", "--as-drawn", "--snr", snrs, "--seed", "3"];
        done(&arguments, &folder(out))
    };
    let said = played("80,60", "a");
    assert!(
        said.contains("told apart"),
        "a table on the terminal: {said}"
    );
    played("60,80", "b");
    played("60", "alone");

    let (a, b) = (files(&folder("a")), files(&folder("b")));
    let names: Vec<&str> = a.keys().map(String::as_str).collect();
    let expected = [
        "accuracy.csv",
        "accuracy.json",
        "accuracy.png",
        "accuracy.svg",
        "bound.csv",
        "discrimination.csv",
        "images.csv",
        "report.html",
        "report.md",
        "shapes.csv",
    ];
    assert_eq!(names, expected);
    for (name, bytes) in &a {
        assert!(b.get(name) == Some(bytes), "{name} differs");
    }

    let (both, alone) = (json(&folder("a")), json(&folder("alone")));
    for touches in 0..=3 {
        let [both, alone] = [&both, &alone].map(|found| {
            let mut one = at(found, touches, 60.0);
            // The scale of force is taken at the highest SNR of the study.
            one.as_object_mut()
                .expect("an object")
                .remove("force_error");
            one
        });
        assert_eq!(
            both, alone,
            "no result depends on the other SNRs of a study"
        );
    }
    assert_eq!(both["discrimination"], alone["discrimination"]);

    // Single touches at 60 dB: an image's centroid errs by 1 to 2 mm, the bound is 0.10 to 0.16 mm (rms).
    let one = at(&both, 1, 60.0);
    assert_eq!(
        (&one["missed"], &one["false_touches"]),
        (&0.into(), &0.into())
    );
    assert!(number(&one["place_error_mm"]["mean"]) < 2.0);
    let bound_mm = number(&one["place_bound_mm"]["median"]);
    assert!((0.05..0.25).contains(&bound_mm), "{bound_mm}");
    // A tenth of the noise is a tenth of the bound.
    let at_80 = number(&at(&both, 1, 80.0)["place_bound_mm"]["median"]);
    assert!((bound_mm / at_80 - 10.0).abs() < 1e-6);
    // The bound is that of methods that know nothing of fingers. Ours expects typical ones and may be better, but not several times.
    let over_bound = number(&both["bound"]["ratio"]["median"]);
    assert!((0.25..1.3).contains(&over_bound), "{over_bound}");
    let pairs = both["discrimination"]["pairs"].as_array().expect("a list");
    let told = |index: usize| number(&pairs[index]["told_apart"]["share"]);
    assert!(told(pairs.len() - 1) > 0.9, "at 40 mm two are two");
}

#[test]
fn identified_pads_are_located_better_than_drawn_ones() {
    let root = tempfile::tempdir().expect("a folder");
    let error_mm = |options: &[&str], name: &str| {
        let out = root.path().join(name);
        done(&[&["--quick", "--snr", "80"], options].concat(), &out);
        let found = json(&out);
        let command = found["command"].as_str().expect("a text");
        assert_eq!(command.contains("--as-drawn"), !options.is_empty());
        number(&at(&found, 1, 80.0)["place_error_mm"]["mean"])
    };
    let (identified, drawn) = (
        error_mm(&[], "identified"),
        error_mm(&["--as-drawn"], "drawn"),
    );
    assert!(
        identified < 0.7 * drawn,
        "{identified} mm, {drawn} mm as drawn"
    );
}

/// In play, a pad that was found before is not identified again.
#[test]
fn a_pad_that_was_found_before_stays_as_it_is() {
    let root = tempfile::tempdir().expect("a folder");
    let pad = root.path().join("found.toml").display().to_string();
    let untouched = concat!(
        "replay:",
        env!("CARGO_MANIFEST_DIR"),
        "/tests/data/lattice-presses/session.csv"
    );
    let identified = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .args(["pad", "identify", "--source", untouched, "-o", &pad])
        .output()
        .expect("started");
    assert!(identified.status.success());
    let touches = |options: &[&str], name: &str| {
        let out = root.path().join(name);
        let quick = ["--pad", &pad, "--quick", "--snr", "80"];
        done(&[&quick, options].concat(), &out);
        fs::read(out.join("accuracy.csv")).expect("written")
    };
    let as_drawn = touches(&["--as-drawn"], "drawn");
    assert!(touches(&[], "play") == as_drawn, "it was identified again");
}

#[test]
fn noise_as_large_as_the_readings_makes_no_touch() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("noise");
    // Noise as large as the readings.
    done(&["--quick", "--snr", "0"], &out);
    let found = json(&out);
    let untouched = at(&found, 0, 0.0);
    assert_eq!(number(&untouched["false_touches"]), 0.0, "{untouched}");
}

#[test]
fn round_pads_and_other_protocols_are_supported() {
    let root = tempfile::tempdir().expect("a folder");
    // A small pad on which lengths are scaled, and a tank with opposite drive.
    let small = include_str!("../pads/edinburgh-solid.toml")
        .replace("width_mm = 100.0", "width_mm = 60.0")
        .replace("height_mm = 100.0", "height_mm = 40.0")
        .replace("width_mm = 3.0", "width_mm = 2.0");
    let tank = include_str!("../pads/round-tank.toml")
        .replace("stimulation = \"adjacent\"", "stimulation = \"opposite\"");
    for (name, text, scale) in [("small", small, 0.4), ("tank", tank, 1.0)] {
        let pad = root.path().join(format!("{name}.toml"));
        fs::write(&pad, text).expect("written");
        let out = root.path().join(name);
        let pad = pad.display().to_string();
        done(
            &["--pad", &pad, "--quick", "--as-drawn", "--snr", "80"],
            &out,
        );
        let found = json(&out);
        assert_eq!(number(&found["length_scale"]), scale, "{name}");
        let one = at(&found, 1, 80.0);
        assert!(
            number(&one["place_bound_mm"]["median"]) < 1.0,
            "{name}: {one}"
        );
        let places = found["bound"]["places"].as_array().expect("a list");
        assert!(
            !places.is_empty(),
            "{name}: places to compare with the bound"
        );
    }
}

#[test]
fn a_row_of_white_noise_and_round_fingers_has_the_bound_beside_its_errors() {
    let folder = tempfile::tempdir().expect("a folder");
    for (only, is_bounded) in [("rise of 10", true), ("common gain, 60", false)] {
        let out = folder.path().join(only);
        let output = accuracy(&["--real", "--quick", "--seed", "1", "--only", only], &out);
        assert!(output.status.success(), "{output:?}");
        let text = fs::read_to_string(out.join("real.json")).expect("findings");
        let found: Value = serde_json::from_str(&text).expect("JSON");
        let row = &found["conditions"][0];
        assert_eq!(row["bound_mm"].is_number(), is_bounded, "{row}");
        if is_bounded {
            // What typical fingers are like is known, so that the errors may be somewhat below it.
            let (bound, first) = (number(&row["bound_mm"]), number(&row["first_mm"]["mean"]));
            assert!((0.5..1.5).contains(&(first / bound)), "{first} {bound}");
        }
    }
}

/// On pads of this seed, channels of few steps once pulled the reference, and deformations were made of noise: touches of 120 and 260 ms.
#[test]
fn a_coarse_converter_makes_no_touches_that_last() {
    let folder = tempfile::tempdir().expect("a folder");
    let study = [
        "--real",
        "--seed",
        "7",
        "--disturb",
        "adc:12",
        "--snr",
        "70",
    ];
    let output = accuracy(&study, folder.path());
    assert!(output.status.success(), "{output:?}");
    let text = fs::read_to_string(folder.path().join("real.json")).expect("findings");
    let found: Value = serde_json::from_str(&text).expect("JSON");
    let conditions = found["conditions"].as_array().expect("a list");
    assert_eq!(conditions.len(), 2, "a finger, and an untouched pad");
    for row in conditions {
        assert!(number(&row["longest_ms"]) <= 50.0, "{row}");
    }
}

/// Fingers so wide that two touches nearly explain them: the search once added a touch and removed another without end.
#[test]
fn the_search_for_a_very_wide_finger_ends() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut study = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .args([
            "accuracy",
            "--real",
            "--seed",
            "23",
            "--only",
            "radius 15",
            "--out",
        ])
        .arg(folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("started");
    // Five seconds on an idle machine.
    for _ in 0..1200 {
        if let Some(status) = study.try_wait().expect("a status") {
            assert!(status.success(), "{status}");
            return;
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    study.kill().expect("killed");
    panic!("still searching after two minutes");
}

#[test]
fn invalid_input_is_rejected_before_anything_is_solved() {
    let root = tempfile::tempdir().expect("a folder");
    let taken = root.path().join("taken");
    fs::write(&taken, "a file").expect("written");
    let never = root.path().join("never");
    let cases: [(&[&str], &Path, i32, &str); 7] = [
        (&["--snr", "loud"], &never, 2, "a ratio in dB, 0 to 300"),
        (&["--snr", "60,,40"], &never, 2, "a ratio in dB, 0 to 300"),
        (&["--snr", "60,-5"], &never, 2, "a ratio in dB, 0 to 300"),
        (
            &["--pad", "edinburg-lattice"],
            &never,
            1,
            "did you mean `edinburgh-lattice`?",
        ),
        (&["--pad", "./no-such.toml"], &never, 1, "no-such.toml"),
        (&["--quick"], &taken, 1, "taken"),
        (
            &["--real", "--disturb", "adc:12", "--only", "spikes"],
            &never,
            1,
            "no condition's name contains `spikes`; the conditions are:\n  a finger\n  untouched",
        ),
    ];
    for (arguments, out, code, says) in cases {
        let output = accuracy(arguments, out);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {stderr}");
        assert!(stderr.contains(says), "{arguments:?}: {stderr}");
        assert!(!never.exists(), "nothing was started");
    }
}
