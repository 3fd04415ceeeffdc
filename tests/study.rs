//! `gelpad study`: results against an independent model, the commands printed in reports, and folders that are resumed,
//! sharded and merged with the same files, byte for byte.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use gelpad::pad::{DEFAULT_PAD, shipped_pad};
use gelpad::study::job::Study as _;
use gelpad::study::phantoms::{PhantomSettings, Phantoms, phantoms};

/// Mean |dV| (mV/A) and mean |dV/V| (%) at 5 S/m over the three phantoms, by an independent 2-D model on bilinear
/// quadrilaterals, from the solid layer to channels of 1 mm.
const INDEPENDENT: [(&str, f64, f64); 6] = [
    ("solid", 0.633, 3.23),
    ("5 mm", 0.933, 2.95),
    ("4 mm", 1.19, 2.89),
    ("3 mm", 1.62, 2.83),
    ("2 mm", 2.48, 2.76),
    ("1 mm", 4.99, 2.68),
];

fn study(arguments: &[&str], out: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelpad"));
    command
        .arg("study")
        .args(arguments)
        .arg("--out")
        .arg(out)
        .stdin(Stdio::null());
    command
}

fn done(command: &mut Command) {
    let Output { status, stderr, .. } = command.output().expect("started");
    assert!(status.success(), "{}", String::from_utf8_lossy(&stderr));
}

/// Every file of a folder by its name.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path
                    .strip_prefix(folder)
                    .expect("inside")
                    .display()
                    .to_string();
                files.insert(name, fs::read(&path).expect("a file"));
            }
        }
    }
    files
}

fn assert_same(ours: &Path, theirs: &Path) {
    let (ours, theirs) = (files(ours), files(theirs));
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&ours), names(&theirs));
    for (name, bytes) in &ours {
        assert!(bytes == &theirs[name], "{name} differs");
    }
}

#[test]
fn the_width_study_agrees_with_an_independent_model() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("width");
    done(&mut study(&["width", "--quick"], &out));
    let mut sums: BTreeMap<String, [f64; 2]> = BTreeMap::new();
    let mut table = csv::Reader::from_path(out.join("phantoms.csv")).expect("a table");
    for row in table.records() {
        let row = row.expect("a row");
        if &row[2] == "5" {
            let sum = sums.entry(row[0].to_owned()).or_default();
            sum[0] += row[3].parse::<f64>().expect("a number") * 1e3 / 3.0;
            sum[1] += row[4].parse::<f64>().expect("a number") * 1e2 / 3.0;
        }
    }
    for (variant, absolute, relative) in INDEPENDENT {
        let [ours_absolute, ours_relative] = sums[variant];
        println!(
            "{variant}: {ours_absolute:.3} mV/A for {absolute}, {ours_relative:.2} % for {relative}"
        );
        assert!((ours_absolute / absolute - 1.0).abs() < 0.05, "{variant}");
        assert!((ours_relative / relative - 1.0).abs() < 0.05, "{variant}");
    }
}

#[test]
fn killed_and_sharded_studies_end_with_the_same_files() {
    let root = tempfile::tempdir().expect("a folder");
    let at = |name: &str| root.path().join(name);
    let sweep = ["width", "--quick", "--vary", "lattice.width=2..4:1"];
    done(&mut study(&sweep, &at("whole")));

    let mut child = study(&sweep, &at("killed"))
        .stdout(Stdio::null())
        .spawn()
        .expect("started");
    let cases = at("killed").join("cases");
    for _ in 0..6000 {
        if fs::read_dir(&cases).is_ok_and(|mut entries| entries.next().is_some()) {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
    assert!(
        !at("killed").join("report.html").exists(),
        "it was killed before the end"
    );
    done(&mut study(&sweep, &at("killed")));
    assert_same(&at("whole"), &at("killed"));

    // Two shards, joined.
    for shard in ["1/2", "2/2"] {
        let folder = at(&shard.replace('/', "-"));
        done(study(&sweep, &folder).args(["--shard", shard]));
        assert!(
            !folder.join("report.html").exists(),
            "a shard has no report"
        );
    }
    let parts = ["1-2", "2-2"].map(|name| at(name).display().to_string());
    done(&mut study(&["merge", &parts[0], &parts[1]], &at("merged")));
    assert_same(&at("whole"), &at("merged"));

    // A folder of another study leaves nothing behind.
    let mut other = sweep.to_vec();
    other.extend(["--seed", "2"]);
    let folder = at("other");
    done(study(&other, &folder).args(["--shard", "1/8"]));
    let folder = folder.display().to_string();
    let mut merge = study(&["merge", &parts[0], &folder], &at("mixed"));
    let output = merge.output().expect("gelpad runs");
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("holds another study"), "{said}");
    assert!(!at("mixed").exists(), "nothing was written");
}

#[test]
fn impossible_parameters_are_refused_before_anything_is_solved() {
    let root = tempfile::tempdir().expect("a folder");
    let cases = [
        ("lattice.width=1..20:1", "channels of 10 mm overlap"),
        (
            "outline.width=60..60:1",
            "the touch at (70, 50) mm reaches off the pad",
        ),
        (
            "lattice.colour=1..2:1",
            "has no number `lattice.colour` to vary",
        ),
    ];
    for (vary, reason) in cases {
        let out = root.path().join("never");
        let Output { status, stderr, .. } = study(&["width", "--vary", vary], &out)
            .output()
            .expect("started");
        let stderr = String::from_utf8_lossy(&stderr);
        assert_eq!(status.code(), Some(1), "{stderr}");
        assert!(stderr.contains(reason), "{vary}: {stderr}");
        assert!(!out.exists(), "nothing was started");
    }
}

#[test]
fn a_sweep_ranks_its_variants() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("sweep");
    done(&mut study(
        &[
            "width",
            "--quick",
            "--vary",
            "lattice.width=2..3:1",
            "--rank",
            "change",
        ],
        &out,
    ));
    let report = fs::read_to_string(out.join("report.md")).expect("a report");
    let ranked: Vec<&str> = report
        .lines()
        .filter_map(|line| line.strip_prefix("| "))
        .filter_map(|line| line.split(' ').next())
        .filter(|word| word.parse::<f64>().is_ok())
        .collect();
    assert_eq!(ranked, ["2", "3"], "narrow channels change more");
    assert!(
        report.contains("--vary lattice.width=2..3:1 --rank change --quick"),
        "the exact command"
    );
}

#[test]
fn a_press_makes_readings_rise_and_a_local_rise_makes_them_fall() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("thickness");
    let words = "thickness --quick --layers 2 --depths 1,2.5 --table-shares 0.25";
    let words: Vec<&str> = words.split(' ').collect();
    done(&mut study(&words, &out));
    let mut table = csv::Reader::from_path(out.join("touches.csv")).expect("a table");
    let rows: Vec<BTreeMap<String, String>> =
        table.deserialize().collect::<Result<_, _>>().expect("rows");
    let pressed: Vec<(&str, &str)> = rows
        .iter()
        .map(|row| (row["touch"].as_str(), row["depth_mm"].as_str()))
        .collect();
    assert_eq!(
        pressed,
        [
            ("local rise", "0"),
            ("held at its edge", "1"),
            ("held at its edge", "2.5"),
            ("on a soft foundation", "1"),
            ("on a soft foundation", "2.5"),
            ("on a rigid table", "1"),
            ("on a rigid table", "1"),
        ]
    );
    for row in &rows {
        let number = |column: &str| row[column].parse::<f64>().expect("a number");
        if row["touch"] == "local rise" {
            assert!(number("mean_signed") < 0.0, "{row:?}");
        } else {
            assert!(number("mean_signed") > 0.0, "{row:?}");
            assert!(
                number("force_n") > 0.0 && number("height_share") < 1.0,
                "{row:?}"
            );
        }
    }
    let report = fs::read_to_string(out.join("report.md")).expect("a report");
    assert!(
        report.contains("2.5 mm into 4 mm on a rigid table: it leaves room for 2 mm"),
        "{report}"
    );
}

#[test]
fn phantoms_are_at_their_places_and_the_annulus_is_a_ring() {
    for seed in [1, 2, 3] {
        let study = Phantoms::new(PhantomSettings {
            version: "test".to_owned(),
            pad: DEFAULT_PAD.to_owned(),
            pad_toml: shipped_pad(DEFAULT_PAD).expect("shipped").toml.to_owned(),
            quick: false,
            seed,
        })
        .expect("possible");
        for phantom in phantoms() {
            let outcome = study.solve(&phantom).expect("solved");
            let (place_mm, overlap, euler) =
                outcome.figures("L1, 200 iterations").expect("a solver");
            println!(
                "seed {seed}, {}: {place_mm:.2} mm, IoU {overlap:.2}, Euler {euler}",
                phantom.name
            );
            if phantom.name.ends_with("point") || phantom.name.ends_with("points") {
                for solver in ["Tikhonov", "L1, 200 iterations", "L1, optimum"] {
                    let (place_mm, _, _) = outcome.figures(solver).expect("a solver");
                    assert!(
                        place_mm <= 2.0,
                        "{} by {solver}: {place_mm} mm",
                        phantom.name
                    );
                }
            }
            if phantom.name == "annulus" {
                assert_eq!(euler, 0);
                assert!(overlap >= 0.6);
            }
        }
    }
}

/// Starts a shell command until it has written `study.json`, and returns that file's text.
fn settings_of(command: &str, out: &Path) -> String {
    let line = command
        .replacen(
            "gelpad",
            &format!("exec '{}'", env!("CARGO_BIN_EXE_gelpad")),
            1,
        )
        .replace("--out DIR", &format!("--out '{}'", out.display()));
    let mut child = Command::new("sh")
        .args(["-c", &line])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("started");
    let manifest = out.join("study.json");
    for _ in 0..12_000 {
        if manifest.exists() || child.try_wait().expect("a child").is_some() {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let _ = child.kill();
    child.wait().expect("ended");
    fs::read_to_string(&manifest).unwrap_or_else(|error| panic!("{line}: {error}"))
}

/// The command that a report prints for the settings in `study.json`.
fn printed_command(settings: &str) -> String {
    let json: serde_json::Value = serde_json::from_str(settings).expect("JSON");
    let (study, settings) = json
        .as_object()
        .expect("an object")
        .iter()
        .next()
        .expect("a study");
    let settings = settings.clone();
    match study.as_str() {
        "width" => {
            let settings = serde_json::from_value(settings).expect("settings");
            gelpad::study::width::Width::new(settings)
                .expect("valid")
                .command()
        }
        "phantoms" => {
            let settings = serde_json::from_value(settings).expect("settings");
            Phantoms::new(settings).expect("valid").command()
        }
        _ => {
            let settings = serde_json::from_value(settings).expect("settings");
            gelpad::study::thickness::Thickness::new(settings)
                .expect("valid")
                .command()
        }
    }
}

#[cfg(unix)]
#[test]
fn the_printed_command_has_the_same_settings() {
    let root = tempfile::tempdir().expect("a folder");
    let pad = root.path().join("my pad.toml");
    fs::write(&pad, shipped_pad(DEFAULT_PAD).expect("shipped").toml).expect("written");
    let commands = [
        "gelpad study width --out DIR".to_owned(),
        format!(
            "gelpad study width --pad '{}' --seed 7 --vary lattice.width=2..3:0.5 --rank relative --quick --out DIR",
            pad.display()
        ),
        "gelpad study phantoms --out DIR".to_owned(),
        "gelpad study phantoms --seed 3 --quick --out DIR".to_owned(),
        "gelpad study thickness --quick --out DIR".to_owned(),
        "gelpad study thickness --quick --layers 1,2.5 --depths 1 --table-shares 0.3 --indenter-mm 4 --cover-mm 1.5 --silicone-kpa 300 \
         --hydrogel-kpa 30 --poisson 0.49 --foundation-kpa 15 --foundation-mm 10 --rise 3 --out DIR"
            .to_owned(),
    ];
    for (index, command) in commands.iter().enumerate() {
        let settings = settings_of(command, &root.path().join(format!("first-{index}")));
        let printed = printed_command(&settings);
        assert!(printed.ends_with(" --out DIR"), "{printed}");
        let again = settings_of(&printed, &root.path().join(format!("again-{index}")));
        assert_eq!(settings, again, "{command}\n{printed}");
    }
}

#[test]
fn a_quick_phantom_study_has_two_phantoms() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("phantoms");
    done(&mut study(&["phantoms", "--quick"], &out));
    let mut table = csv::Reader::from_path(out.join("merit.csv")).expect("a table");
    let rows: Vec<csv::StringRecord> = table.records().collect::<Result<_, _>>().expect("rows");
    let mut phantoms: Vec<&str> = rows.iter().map(|row| &row[0]).collect();
    phantoms.sort_unstable();
    phantoms.dedup();
    assert_eq!(phantoms, ["annulus", "one point"]);
}

#[test]
fn a_thickness_study_has_no_seed() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("never");
    let output = study(&["thickness", "--seed", "2"], &out)
        .output()
        .expect("started");
    assert_eq!(output.status.code(), Some(2));
    assert!(!out.exists(), "nothing was started");
}

#[test]
fn the_protocol_study_writes_pads_and_tables_that_hold_what_it_says() {
    use gelpad::pad::Pad;

    let root = tempfile::tempdir().expect("a folder");
    let at = |name: &str| root.path().join(name);
    let arguments = ["protocol", "--quick", "--keep", "0.4"];
    done(&mut study(&arguments, &at("whole")));
    for shard in ["1/2", "2/2"] {
        done(study(&arguments, &at(&shard.replace('/', "-"))).args(["--shard", shard]));
    }
    let parts = ["1-2", "2-2"].map(|name| at(name).display().to_string());
    done(&mut study(&["merge", &parts[0], &parts[1]], &at("merged")));
    assert_same(&at("whole"), &at("merged"));

    let text = |name: &str| fs::read_to_string(at("whole").join(name)).expect("written");
    let pad = |name: &str| Pad::from_toml(name, &text(name)).expect("sound");
    let rows = |name: &str| text(name).matches('{').count() - 1;
    let ordered = pad("pad-order.toml");
    assert_eq!((ordered.channels(), rows("readings.h")), (208, 208));
    let standard = shipped_pad(DEFAULT_PAD).expect("shipped");
    let standard = Pad::from_toml(standard.name, standard.toml).expect("sound");
    let sorted = |pad: &Pad| {
        let mut channels = pad.protocol.channels.clone();
        channels.sort_by_key(|channel| (channel.drive, channel.measure));
        channels
    };
    assert_eq!(sorted(&ordered), sorted(&standard));
    // The bound of the readings that are kept is what was asked for, and one reading fewer misses it.
    let fewest = pad("pad-fewest.toml");
    assert_eq!(fewest.channels(), rows("readings-fewest.h"));
    let steps = text("readings.csv");
    let mean_mm = |readings: usize| -> f64 {
        let start = format!("{readings},");
        let line = steps.lines().find(|line| line.starts_with(&start));
        line.expect("a step")
            .split(',')
            .nth(2)
            .expect("a mean")
            .parse()
            .expect("a number")
    };
    assert!(mean_mm(fewest.channels()) <= 0.4, "{steps}");
    assert!(mean_mm(fewest.channels() - 1) > 0.4, "{steps}");
    // An order in the pad's text changes nothing.
    let ordered = at("whole").join("pad-order.toml").display().to_string();
    let again = ["protocol", "--quick", "--keep", "0.4", "--pad", &ordered];
    done(&mut study(&again, &at("again")));
    let orders = [at("whole"), at("again")]
        .map(|folder| fs::read(folder.join("order.csv")).expect("written"));
    assert_eq!(orders[0], orders[1]);
}
