//! `gelpad calibrate` from the command line: a robot presses the simulated pad, presses are learned from, wrong files are refused.

use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;

use gelpad::eit::Reconstruction;
use gelpad::pad::{Pad, shipped_pad};
use gelpad::touch::{Detector, Sensing};
use gelpad::types::{Frame, Method};

fn gelpad(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("gelpad runs")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Presses of an instrument without a pad file: nine channels, each a bump.
fn presses(count: usize, from: usize) -> String {
    let mut text = String::from("x_mm,y_mm,d0,d1,d2,d3,d4,d5,d6,d7,d8\n");
    for i in from..from + count {
        let share = |root: f64| (0.5 + i as f64 * root).fract();
        let (x, y) = (80.0 * share(0.754_877_666), 80.0 * share(0.569_840_29));
        text.push_str(&format!("{x},{y}"));
        for channel in 0..9 {
            let (cx, cy) = (f64::from(channel % 3) * 40.0, f64::from(channel / 3) * 40.0);
            let change = 500.0 * (-((x - cx).powi(2) + (y - cy).powi(2)) / 1200.0).exp();
            text.push_str(&format!(",{change}"));
        }
        text.push('\n');
    }
    text
}

#[test]
fn a_recording_is_learned_from_saved_and_taken_by_replay() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = gelpad(
        folder.path(),
        &[
            "calibrate",
            "--source",
            "simulated",
            "--points",
            "16",
            "--presses",
            "p.csv",
        ],
    );
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(output.stdout.is_empty(), "words go to stderr");
    let said = stderr(&output);
    assert!(said.contains("place 16 of 16"), "{said}");
    assert!(said.contains("a lone touch, corrected: mean"), "{said}");
    assert!(said.contains("expected error: 8 presses"), "{said}");
    assert!(said.contains("more presses teach most at ("), "{said}");
    let header = std::fs::read_to_string(folder.path().join("p.csv")).expect("presses");
    assert!(header.starts_with("x_mm,y_mm,force,model_x_mm,model_y_mm,d0,"));

    let again = gelpad(
        folder.path(),
        &["calibrate", "--presses", "p.csv", "-o", "again.json"],
    );
    assert!(again.status.success(), "{}", stderr(&again));
    let saved = |name: &str| std::fs::read(folder.path().join(name)).expect(name);
    assert!(
        saved("again.json") == saved("edinburgh-lattice.calibration.json"),
        "the same presses give the same calibration"
    );

    let over = gelpad(
        folder.path(),
        &["calibrate", "--source", "simulated", "--presses", "p.csv"],
    );
    assert_eq!(over.status.code(), Some(1));
    assert!(stderr(&over).contains("would be overwritten"));

    refuses_wrong_places(folder.path(), &header);

    let frames = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/data/lattice-presses/session.csv"
    );
    let replayed = gelpad(
        folder.path(),
        &[
            "replay",
            frames,
            "--print",
            "touches",
            "--calibration",
            "again.json",
        ],
    );
    assert!(replayed.status.success(), "{}", stderr(&replayed));
    let refused = gelpad(
        folder.path(),
        &[
            "replay",
            frames,
            "--pad",
            "openeit-lattice",
            "--calibration",
            "again.json",
        ],
    );
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        stderr(&refused).contains("208 channels"),
        "{}",
        stderr(&refused)
    );
}

#[test]
fn presses_of_any_instrument_are_evaluated_as_one_json_object() {
    let folder = tempfile::tempdir().expect("a folder");
    let write =
        |name: &str, text: String| std::fs::write(folder.path().join(name), text).expect(name);
    write("train.csv", presses(60, 0));
    write("test.csv", presses(40, 100));
    let output = gelpad(
        folder.path(),
        &[
            "calibrate",
            "--presses",
            "train.csv",
            "--evaluate",
            "test.csv",
        ],
    );
    assert!(output.status.success(), "{}", stderr(&output));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one object");
    assert_eq!(found["n_train"], 60);
    assert_eq!(found["n_test"], 40);
    let mean = found["mean_mm"].as_f64().expect("a number");
    assert!(mean < 2.0, "{found}");
    assert!(found["median_mm"].as_f64() <= found["p95_mm"].as_f64());
    let single = &found["by_count"]["1"];
    assert_eq!(single["mean_mm"], found["mean_mm"]);
    assert!(single["region_mm"].as_f64() > single["median_mm"].as_f64());
    let share = single["region_share"].as_f64().expect("a number");
    assert!((0.7..=1.0).contains(&share), "{found}");

    let words = gelpad(folder.path(), &["calibrate", "--presses", "train.csv"]);
    assert!(words.status.success());
    for words_of in ["expected error: 15 presses", "more presses teach most at ("] {
        assert!(stderr(&words).contains(words_of), "{}", stderr(&words));
    }
    let saved = gelpad(
        folder.path(),
        &["calibrate", "--presses", "train.csv", "-o", "x.json"],
    );
    assert_eq!(saved.status.code(), Some(1));
    assert!(stderr(&saved).contains("only voltages"));
}

/// The rows of `presses`, each added to a row elsewhere on the pad.
fn pairs(count: usize) -> String {
    let text = presses(2 * count, 300);
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| {
            line.split(',')
                .map(|v| v.parse().expect("a number"))
                .collect()
        })
        .collect();
    let mut text = String::from("x_mm,y_mm,x2_mm,y2_mm,d0,d1,d2,d3,d4,d5,d6,d7,d8\n");
    for (a, b) in rows[..count].iter().zip(&rows[count..]) {
        if (a[0] - b[0]).hypot(a[1] - b[1]) < 25.0 {
            continue;
        }
        text.push_str(&format!("{},{},{},{}", a[0], a[1], b[0], b[1]));
        for (a, b) in a[2..].iter().zip(&b[2..]) {
            text.push_str(&format!(",{}", a + b));
        }
        text.push('\n');
    }
    // One row with a single press.
    let last: Vec<String> = rows[0].iter().map(f64::to_string).collect();
    text + &format!("{},{},,,{}\n", last[0], last[1], last[2..].join(","))
}

#[test]
fn two_touches_are_located_with_maps_from_single_presses() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("train.csv"), presses(80, 0)).expect("train");
    std::fs::write(folder.path().join("pairs.csv"), pairs(30)).expect("pairs");
    let output = gelpad(
        folder.path(),
        &[
            "calibrate",
            "--presses",
            "train.csv",
            "--evaluate",
            "pairs.csv",
        ],
    );
    assert!(output.status.success(), "{}", stderr(&output));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one object");
    assert_eq!(found["by_count"]["1"]["n_test"], 1);
    let two = &found["by_count"]["2"];
    assert!(two["n_test"].as_u64() > Some(10), "{found}");
    assert!(two["mean_mm"].as_f64().expect("a number") < 4.0, "{found}");
}

#[test]
fn presses_whose_places_do_not_belong_to_their_readings_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = presses(60, 0);
    let rows: Vec<(&str, &str)> = text
        .lines()
        .skip(1)
        .map(|line| {
            let readings = line.match_indices(',').nth(1).expect("two places").0;
            line.split_at(readings)
        })
        .collect();
    // Each place with the readings of another one.
    let mut mixed = String::from(text.lines().next().expect("a header"));
    for (index, (place, _)) in rows.iter().enumerate() {
        mixed.push_str(&format!("\n{place}{}", rows[(index * 37 + 11) % 60].1));
    }
    std::fs::write(folder.path().join("mixed.csv"), mixed).expect("mixed");
    std::fs::write(folder.path().join("test.csv"), presses(20, 100)).expect("test");
    let output = gelpad(
        folder.path(),
        &[
            "calibrate",
            "--presses",
            "mixed.csv",
            "--evaluate",
            "test.csv",
        ],
    );
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(output.stdout.is_empty());
    assert!(
        stderr(&output).contains("the presses disagree"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn what_is_no_calibration_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    for (text, message) in [
        ("[]", "this is not a calibration"),
        ("{\"format\":\"x\"}", "this is not a calibration"),
    ] {
        std::fs::write(folder.path().join("c.json"), text).expect("written");
        let output = gelpad(
            folder.path(),
            &[
                "play",
                "--headless",
                "--output",
                "trace",
                "--calibration",
                "c.json",
            ],
        );
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).contains(message), "{}", stderr(&output));
    }
    let output = gelpad(folder.path(), &["calibrate", "--evaluate", "x.csv"]);
    assert_eq!(output.status.code(), Some(2), "--evaluate needs --presses");
}

/// A script of a slow hand that follows the requests: presses of regions of super-mario, short ones of half a second.
fn slow_presses(count: usize) -> String {
    let plain = [(75, 9), (13, 57), (37, 57), (25, 15), (67, 93), (32, 93)];
    let (short_ms, long_ms, gap_ms) = (500, 1400, 600);
    let lengths: [&[u64]; 5] = [
        &[short_ms],
        &[long_ms],
        &[short_ms, short_ms],
        &[short_ms],
        &[long_ms],
    ];
    let (mut script, mut t_ms) = (String::new(), 1000);
    for index in 0..count {
        let (x, y) = if index % 2 == 0 {
            (81, 52)
        } else {
            plain[index / 2 % plain.len()]
        };
        for held_ms in lengths[index / 2 % lengths.len()] {
            let up_ms = t_ms + held_ms;
            script.push_str(&format!("t:{t_ms} down 1 {x} {y}\nt:{up_ms} up 1\n"));
            t_ms = up_ms + gap_ms;
        }
        t_ms += 2500;
    }
    script.push_str(&format!("t:{t_ms} end\n"));
    script
}

#[test]
fn settings_are_recommended_to_a_slow_hand_and_play_takes_them() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("presses.txt"), slow_presses(20)).expect("written");
    let arguments = [
        "calibrate",
        "--source",
        "simulated:presses.txt",
        "--recommend",
        "anna",
        "--points",
        "20",
    ];
    let output = gelpad(folder.path(), &arguments);
    let said = stderr(&output);
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("20 of 20: press down and hold it a second"),
        "{said}"
    );
    assert!(
        said.contains("use it: gelpad play super-mario-classified --user anna"),
        "{said}"
    );
    let text = std::fs::read_to_string(folder.path().join("users/anna.toml")).expect("settings");
    assert!(text.contains("20 are right with these settings"), "{text}");
    assert!(text.contains("classify = \"decided\""), "{text}");
    let shown = gelpad(
        folder.path(),
        &[
            "profile",
            "show",
            "super-mario-classified",
            "--user",
            "anna",
        ],
    );
    assert!(shown.status.success(), "{}", stderr(&shown));

    let again = gelpad(folder.path(), &arguments);
    assert_eq!(again.status.code(), Some(1));
    assert!(stderr(&again).contains("users/anna.toml exists"));
}

/// A profile whose holds take longer than any that is recommended.
const LONG_HOLD: &str = "schema = 1\nname = \"p\"\nhold_ms = 3000\n\n[[region]]\nname = \"a\"\nshape = \"rect\"\nx = 0.6\ny = 0.3\nw = 0.3\nh = 0.4\n\n\
    [[binding]]\nregion = \"a\"\noutput = \"key:a\"\n\n[[binding]]\nregion = \"a\"\ngesture = \"hold\"\noutput = \"key:b\"\n";

#[test]
fn settings_that_would_be_worse_are_not_saved() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("p.toml"), LONG_HOLD).expect("written");
    let (mut script, mut t_ms) = (String::new(), 1000);
    for index in 0..12 {
        // The third length of five is two presses; the lengths change with every second request.
        for _ in 0..(if index / 2 % 5 == 2 { 2 } else { 1 }) {
            let up_ms = t_ms + 2000;
            script.push_str(&format!("t:{t_ms} down 1 75 50\nt:{up_ms} up 1\n"));
            t_ms = up_ms + 600;
        }
        t_ms += 2500;
    }
    script.push_str(&format!("t:{t_ms} end\n"));
    std::fs::write(folder.path().join("presses.txt"), script).expect("written");
    let output = gelpad(
        folder.path(),
        &[
            "calibrate",
            "--source",
            "simulated:presses.txt",
            "--recommend",
            "anna",
            "--profile",
            "./p.toml",
            "--points",
            "12",
        ],
    );
    let said = stderr(&output);
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("12 of 12 presses come out as meant with the profile as it is"),
        "{said}"
    );
    assert!(said.contains("nothing is saved"), "{said}");
    assert!(!folder.path().join("users").exists());
}

#[test]
fn too_few_presses_and_a_missing_script_are_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let few = gelpad(
        folder.path(),
        &["calibrate", "--source", "simulated", "--recommend", "anna"],
    );
    assert_eq!(few.status.code(), Some(1));
    assert!(
        stderr(&few).contains("the simulated pad is not pressed"),
        "{}",
        stderr(&few)
    );
    let without = gelpad(folder.path(), &["calibrate", "--recommend", "anna"]);
    assert_eq!(without.status.code(), Some(2));
}

#[test]
fn changes_are_not_scaled_by_the_weights_of_the_channels() {
    let shipped = shipped_pad("openeit-lattice").expect("shipped");
    let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
    let matrix = Reconstruction::from_pad(&pad, Method::default()).expect("a matrix");
    let mut sensing = Sensing::by_image(Arc::new(matrix));
    sensing.image_weights.fill(0.5);
    let mut detector = Detector::for_pad(Arc::new(sensing), &pad.protocol);
    for index in 0..30 {
        let volts = (0..pad.channels()).map(|channel| {
            let noise = 1e-4 * ((index * (channel + 3)) as f32).sin();
            let pressed = index == 29 && channel == 7;
            (1.0 + noise) * if pressed { 0.9 } else { 1.0 }
        });
        let frame = Frame {
            t_ns: index as u64 * 10_000_000,
            volts: volts.collect(),
        };
        detector.process_frame(&frame, &mut Vec::new());
    }
    let (changes, _) = detector.changes_and_explained();
    assert!((changes[7] + 0.1).abs() < 1e-3, "{}", changes[7]);
}

/// Presses with shuffled places, and one off the pad, are refused, and the calibration before them stays.
fn refuses_wrong_places(folder: &Path, presses: &str) {
    let rows: Vec<Vec<&str>> = presses
        .lines()
        .map(|row| row.splitn(3, ',').collect())
        .collect();
    let before = std::fs::read(folder.join("again.json")).expect("learned before");
    let learn = |places: &dyn Fn(usize) -> [String; 2]| {
        let mut text = format!("{}\n", rows[0].join(","));
        for (index, row) in rows[1..].iter().enumerate() {
            let [x, y] = places(index);
            text.push_str(&format!("{x},{y},{}\n", row[2]));
        }
        std::fs::write(folder.join("wrong.csv"), text).expect("written");
        let refused = gelpad(
            folder,
            &["calibrate", "--presses", "wrong.csv", "-o", "again.json"],
        );
        assert_eq!(refused.status.code(), Some(1), "{}", stderr(&refused));
        let after = std::fs::read(folder.join("again.json")).expect("learned before");
        assert!(after == before, "the calibration was overwritten");
        stderr(&refused)
    };
    let place = |index: usize| [0, 1].map(|axis| rows[1 + index][axis].to_owned());
    let count = rows.len() - 1;
    let shuffled = learn(&|index| place((7 * index + 3) % count));
    assert!(shuffled.contains("the presses disagree"), "{shuffled}");
    let off = learn(&|index| match index {
        2 => ["500".to_owned(), "20".to_owned()],
        _ => place(index),
    });
    assert!(
        off.contains("press 3 lies at (500, 20) mm, off the pad"),
        "{off}"
    );
}
