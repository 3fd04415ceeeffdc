//! A pad without a model: learned from presses at known places by `gelpad calibrate`, then played.
//!
//! The skin of these tests is no electrical model at all: each of its readings answers to presses in two places of its own, by
//! smooth bumps of either sign, so no drawing could describe it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

const SIDE_MM: f64 = 80.0;
/// Those of opposite drives and adjacent measurements with 16 electrodes.
const CHANNELS: usize = 192;
const FRAME_MS: usize = 10;

fn gelpad(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("gelpad runs")
}

/// What a command prints, if it succeeds.
fn printed(folder: &Path, arguments: &[&str]) -> String {
    let output = gelpad(folder, arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}: {said}");
    String::from_utf8(output.stdout).expect("text")
}

/// What a command says when it fails with exit code 1.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = gelpad(folder, arguments);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}");
    String::from_utf8(output.stderr).expect("text")
}

/// The part after the point of a multiple of an irrational number: evenly spread over 0 to 1.
fn spread(index: usize, root: f64) -> f64 {
    (0.5 + index as f64 * root).fract()
}

fn untouched(channel: usize) -> f64 {
    200.0 + 1800.0 * spread(channel, 0.618_033_99)
}

/// The change of a reading by a press at a place, as a share of the untouched reading.
fn response(channel: usize, [x, y]: [f64; 2]) -> f64 {
    let bump = |seed: usize| {
        let [cx, cy] = [0.754_877_666, 0.569_840_29].map(|root| SIDE_MM * spread(seed, root));
        let width_mm = 14.0 + 14.0 * spread(seed, 0.414_213_56);
        let size = 0.06 * (spread(seed, 0.732_050_81) - 0.5);
        size * (-((x - cx).powi(2) + (y - cy).powi(2)) / (2.0 * width_mm * width_mm)).exp()
    };
    bump(2 * channel) + bump(2 * channel + 1)
}

/// A number that looks random, -1 to 1.
fn noise(index: usize) -> f64 {
    2.0 * (1.0e4 * (index as f64 * 12.9898).sin()).rem_euclid(1.0) - 1.0
}

fn place(index: usize) -> [f64; 2] {
    [0.754_877_666, 0.569_840_29].map(|root| SIDE_MM * spread(index, root))
}

/// A file of presses: differences in the board's unit. `place_of` names the place that is written for a press.
fn presses(count: usize, with_untouched: bool, place_of: impl Fn(usize) -> usize) -> String {
    let titles: String = (0..CHANNELS).map(|c| format!(",d{c}")).collect();
    let mut text = format!("x_mm,y_mm{titles}\n");
    for index in 0..count {
        let [x, y] = place(place_of(index));
        text.push_str(&format!("{x:.3},{y:.3}"));
        let force = 1.0 + 0.2 * noise(index);
        for c in 0..CHANNELS {
            let change = untouched(c)
                * (force * response(c, place(index)) + 1e-4 * noise(index * CHANNELS + c));
            text.push_str(&format!(",{change:.6}"));
        }
        text.push('\n');
    }
    if with_untouched {
        let readings: String = (0..CHANNELS)
            .map(|c| format!(",{:.4}", untouched(c)))
            .collect();
        text.push_str(&format!(",{readings}\n"));
    }
    text
}

/// A press of the test: its place, and its first frame and that after its last.
type TimedPress = ([f64; 2], std::ops::Range<usize>);

/// Frames of the skin while it is pressed.
fn frames(count: usize, pressed: &[TimedPress]) -> String {
    let titles: String = (0..CHANNELS).map(|c| format!(",v{c}")).collect();
    let mut text = format!("t_ms{titles}\n");
    for frame in 0..count {
        text.push_str(&(frame * FRAME_MS).to_string());
        for c in 0..CHANNELS {
            let down = pressed.iter().filter(|(_, frames)| frames.contains(&frame));
            let change: f64 = down.map(|(place, _)| response(c, *place)).sum();
            let noise = 3e-4 * noise(7 + frame * CHANNELS + c);
            text.push_str(&format!(",{:.4}", untouched(c) * (1.0 + change + noise)));
        }
        text.push('\n');
    }
    text
}

/// In `jump`, `right` and `left` of super-mario, on a pad of 80 mm.
const JUMP: [f64; 2] = [65.0, 40.0];
const RIGHT: [f64; 2] = [29.6, 45.0];
const LEFT: [f64; 2] = [10.0, 45.0];

/// A folder with the presses, the pad that was learned from them, and a stream of frames.
fn learned() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    fs::write(path.join("presses.csv"), presses(80, true, |index| index)).expect("written");
    let stream = frames(
        700,
        &[
            (JUMP, 200..208),
            (RIGHT, 240..400),
            (JUMP, 300..360),
            (LEFT, 450..460),
            (JUMP, 600..605),
        ],
    );
    fs::write(path.join("stream.csv"), stream).expect("written");
    let learn = [
        "calibrate",
        "--presses",
        "presses.csv",
        "--size",
        "80x80",
        "-o",
        "skin.toml",
    ];
    let output = gelpad(path, &learn);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("16 of 16 presses that were left out are found: mean"),
        "{said}"
    );
    folder
}

#[test]
fn a_pad_that_has_only_presses_plays_to_the_frame() {
    let folder = learned();
    let replayed = |pad: [&str; 2]| {
        let profile = ["--profile", "super-mario"];
        printed(
            folder.path(),
            &[&["replay", "stream.csv"], &pad[..], &profile].concat(),
        )
    };
    let events = replayed(["--pad", "./skin.toml"]);
    assert_eq!(
        events,
        "2000.000 press key:f\n2080.000 release key:f\n\
         2400.000 press key:right\n3000.000 press key:f\n3600.000 release key:f\n4000.000 release key:right\n\
         4500.000 press key:left\n4600.000 release key:left\n\
         6000.000 press key:f\n6050.000 release key:f\n"
    );
    assert_eq!(replayed(["--calibration", "skin.toml"]), events);
}

#[test]
fn a_recording_of_a_learned_pad_replays_without_its_files() {
    let folder = learned();
    let other = tempfile::tempdir().expect("a folder");
    for (name, slim) in [("whole.mcap", &[][..]), ("slim.mcap", &["--slim"])] {
        let play = [
            "play",
            "super-mario",
            "--source",
            "replay:stream.csv",
            "--calibration",
            "skin.toml",
        ];
        let file = other.path().join(name);
        let file = file.to_str().expect("text");
        printed(
            folder.path(),
            &[&play[..], &["--output", "trace", "--record", file], slim].concat(),
        );
        printed(other.path(), &["replay", name, "--expect", name]);
    }
    let whole = fs::metadata(other.path().join("whole.mcap"))
        .expect("recorded")
        .len();
    let slim = fs::metadata(other.path().join("slim.mcap"))
        .expect("recorded")
        .len();
    assert!(3 * slim < whole, "{slim} of {whole} bytes");
}

#[test]
fn the_simulated_pad_can_be_one_that_was_learned() {
    let folder = learned();
    let script = "t:1000 down 1 65 40\nt:1200 up 1\nt:1500 end\n";
    fs::write(folder.path().join("press.txt"), script).expect("written");
    let play = [
        "play",
        "super-mario",
        "--pad",
        "./skin.toml",
        "--source",
        "simulated:press.txt",
        "--output",
        "trace",
    ];
    let events = printed(folder.path(), &play);
    assert!(
        events.contains("press key:f") && events.contains("release key:f"),
        "{events}"
    );
}

#[test]
fn presses_that_give_no_pad_are_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let try_learning = |text: String, size: &str| {
        fs::write(path.join("p.csv"), text).expect("written");
        let said = refused(
            path,
            &[
                "calibrate",
                "--presses",
                "p.csv",
                "--size",
                size,
                "-o",
                "no.toml",
            ],
        );
        assert!(!path.join("no.toml").exists(), "{said}");
        said
    };
    let said = try_learning(presses(60, false, |index| index), "80x80");
    assert!(said.contains("not what the untouched pad reads"), "{said}");
    let said = try_learning(presses(60, true, |index| (index * 7) % 60), "80x80");
    assert!(said.contains("the presses disagree"), "{said}");
    let said = try_learning(presses(60, true, |index| index), "40x40");
    assert!(said.contains("off the pad"), "{said}");
    let said = try_learning(presses(5, true, |index| index), "80x80");
    assert!(
        said.contains("5 presses, but at least 8 are needed"),
        "{said}"
    );
    let said = try_learning(presses(9, true, |index| index), "80x80");
    assert!(
        said.contains("9 presses, but at least 10 are needed"),
        "{said}"
    );
    let both = presses(60, true, |index| index);
    let twice = format!("{both}{}\n", both.lines().last().expect("a row"));
    let said = try_learning(twice, "80x80");
    assert!(said.contains("several rows without a place"), "{said}");
    let said = refused(path, &["calibrate", "--presses", "p.csv", "-o", "no.toml"]);
    assert!(said.contains("several rows without a place"), "{said}");
    fs::write(path.join("p.csv"), both).expect("written");
    let said = refused(path, &["calibrate", "--presses", "p.csv", "-o", "no.toml"]);
    assert!(
        said.contains("have 192 channels, but the pad edinburgh-lattice has 208"),
        "{said}"
    );
}

#[test]
fn what_needs_a_drawing_says_so() {
    let folder = learned();
    let learn = [
        "calibrate",
        "--presses",
        "presses.csv",
        "--pad",
        "./skin.toml",
        "-o",
        "skin.toml",
    ];
    let said = refused(folder.path(), &learn);
    assert!(said.contains("skin.toml exists"), "{said}");
    for command in [
        &["accuracy", "--pad", "./skin.toml", "--quick", "--out", "a"][..],
        &["study", "width", "--pad", "./skin.toml", "--out", "b"],
        &["pad", "identify", "./skin.toml"],
    ] {
        let said = refused(folder.path(), command);
        assert!(said.contains("was learned from presses"), "{said}");
    }
}

#[test]
fn damaged_maps_are_refused_at_their_place() {
    let folder = learned();
    let text = fs::read_to_string(folder.path().join("skin.toml")).expect("written");
    let start = text.find("responses = ").expect("maps");
    for (from, to, message) in [
        (
            "counts = [25, 25]",
            "counts = [25, 1]",
            "`counts` are 2 or more places",
        ),
        (
            "counts = [25, 25]",
            "counts = [25, 24]",
            "`responses` are 600 lists",
        ),
        (
            "deviations = [",
            "deviations = [-1.0, ",
            "`deviations` are 192 numbers above 0",
        ),
    ] {
        fs::write(folder.path().join("odd.toml"), text.replacen(from, to, 1)).expect("written");
        let said = refused(folder.path(), &["pad", "check", "odd.toml"]);
        assert!(said.contains(message), "{said}");
        assert!(
            said.len() < 2000,
            "a line of thousands of numbers is not printed whole"
        );
    }
    let mut odd = text.clone();
    let number = start + text[start..].find("\n  [").expect("a list") + 4;
    odd.insert_str(number, "nan, ");
    fs::write(folder.path().join("odd.toml"), odd).expect("written");
    let said = refused(folder.path(), &["pad", "check", "odd.toml"]);
    assert!(said.contains("list 1 of `responses` is not of"), "{said}");
}

#[test]
fn a_disturbed_board_plays_a_learned_pad() {
    let folder = learned();
    let mut script = String::new();
    for press in 0..8 {
        // Electrodes are lost after 3 s: between two presses.
        let (start, [x, y]) = (2250 + 500 * press, JUMP);
        script.push_str(&format!(
            "t:{start} down 1 {x} {y}\nt:{} up 1\n",
            start + 40 + 20 * press
        ));
    }
    fs::write(folder.path().join("presses.txt"), script).expect("written");
    // In real time: all at once.
    let disturbances = [
        "gain:60,spikes:0.3",
        "lost-pair",
        "bad-frame:10",
        "garbage-start",
        "adc:12",
    ];
    let games = disturbances.map(|disturbance| {
        let child = Command::new(env!("CARGO_BIN_EXE_gelpad"))
            .current_dir(folder.path())
            .args([
                "play",
                "super-mario",
                "--pad",
                "./skin.toml",
                "--output",
                "trace",
            ])
            .args([
                "--source",
                "simulated:presses.txt",
                "--disturb",
                disturbance,
            ])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        (disturbance, child.expect("gelpad runs"))
    });
    for (disturbance, game) in games {
        let output = game.wait_with_output().expect("ended");
        let events = String::from_utf8(output.stdout).expect("text");
        let count = |what: &str| events.lines().filter(|line| line.contains(what)).count();
        let counts = [count("press key:f"), count("press"), count("release")];
        assert_eq!(counts, [8; 3], "{disturbance}: {events}");
    }
}
