//! Texts, names and streams that are meant to do harm: nothing reaches a terminal raw, nothing takes quadratic time.

#![allow(
    clippy::disallowed_methods,
    reason = "a limit of time is measured by the clock"
)]

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Ten times what a busy computer needs; quadratic checks took minutes.
const PATIENCE: Duration = Duration::from_secs(60);
const SESSION: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/tests/data/recordings/version-1.mcap"
);

fn gelpad(folder: &Path, arguments: &[&str], input: &[u8]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .args(arguments)
        .current_dir(folder)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("gelpad starts");
    let mut stdin = child.stdin.take().expect("a pipe");
    // It may end before it has read everything.
    let _ = stdin.write_all(input);
    drop(stdin);
    child.wait_with_output().expect("ended")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn all_text(output: &Output) -> String {
    said(output) + &String::from_utf8_lossy(&output.stdout)
}

#[test]
fn no_control_character_reaches_the_terminal() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let evil = "\u{1b}]0;x\u{7}\u{9b}31m";
    let file = format!("./a{evil}.toml");
    // TOML allows no raw control characters but C1, so those of C0 are escaped.
    let escaped = "\\u001b]0;x\\u0007";
    let profile = format!(
        "schema = 1\nname = \"n{escaped}\"\nabout = \"{escaped}\u{9b}\"\n\
         [[region]]\nname = \"r{escaped}\"\nx = 0\ny = 0\nw = 1\nh = 1\n\
         [[binding]]\nregion = \"r{escaped}\"\noutput = \"key:f\"\n"
    );
    fs::write(folder.join(&file), &profile).expect("written");
    let wrong = profile.replace("key:f", &format!("key:{escaped}"));
    fs::write(folder.join("wrong.toml"), wrong).expect("written");
    let raw = profile.replace("about", &format!("about{evil}"));
    fs::write(folder.join("raw.toml"), raw).expect("written");
    fs::write(folder.join("frames.csv"), format!("t_ms,{evil}\n{evil}\n")).expect("written");
    for arguments in [
        &["profile", "check", &file][..],
        &["profile", "show", &file],
        &["profile", "check", "wrong.toml"],
        &["profile", "check", "raw.toml"],
        &["profile", "check", evil],
        &["pad", "check", &file],
        &["replay", "frames.csv"],
        &["replay", &file],
        &["play", "--user", evil],
        &["play", "--source", evil],
        &["play", "--pad", evil],
        &["recover", &file, "-o", evil],
        &[evil],
    ] {
        let text = all_text(&gelpad(folder, arguments, b""));
        let harmful = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
        assert!(!text.chars().any(harmful), "{arguments:?}: {text:?}");
        assert!(!text.is_empty(), "{arguments:?}");
    }
}

/// Regions in a square, with a binding each.
fn many_regions(count: usize) -> String {
    let side = (count as f64).sqrt().ceil();
    let size = 1.0 / side;
    let mut text = "schema = 1\nname = \"many\"\n".to_owned();
    for index in 0..count {
        let (x, y) = (
            (index as f64 % side) * size,
            (index as f64 / side).floor() * size,
        );
        let _ = write!(
            text,
            "[[region]]\nname=\"r{index}\"\nx={x:.4}\ny={y:.4}\nw={size:.4}\nh={size:.4}\n\
             [[binding]]\nregion=\"r{index}\"\noutput=\"key:f\"\n"
        );
    }
    text
}

#[test]
fn checks_of_large_profiles_take_little_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let overlapping = (0..4000).fold("schema = 1\nname = \"o\"\n".to_owned(), |text, index| {
        text + &format!("[[region]]\nname=\"r{index}\"\nx=0\ny=0\nw=1\nh=1\nexclusive=false\n")
    });
    let unknown = (0..4000).fold("schema = 1\nname = \"u\"\n".to_owned(), |text, index| {
        text + &format!("[[binding]]\nregion=\"r{index}\"\noutput=\"key:x{index}\"\n")
    });
    let base = "[[binding]]\nregion=\"r0\"\noutput=\"key:f\"\n";
    for (name, text, code) in [
        ("many.toml", many_regions(9000), 0),
        ("over.toml", overlapping + base, 0),
        ("unknown.toml", unknown, 1),
        (
            "extends.toml",
            "schema = 1\nname = \"e\"\nextends = \"./many.toml\"\n".to_owned(),
            0,
        ),
    ] {
        fs::write(folder.join(name), text).expect("written");
        let start = Instant::now();
        let output = gelpad(folder, &["profile", "check", &format!("./{name}")], b"");
        let took = start.elapsed();
        println!("{name}: {took:.1?}");
        let text = all_text(&output);
        assert_eq!(output.status.code(), Some(code), "{name}: {text:.2000}");
        assert!(took < PATIENCE, "{name}: {took:?}");
        assert!(text.len() < 100_000, "{name}: {} bytes", text.len());
    }
}

#[test]
fn limits_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let grids = (0..100).fold("schema = 1\nname = \"g\"\n".to_owned(), |text, index| {
        text + &format!(
            "[[region]]\nname=\"g{index}\"\nshape=\"grid\"\ncolumns=16\nrows=16\nx=0\ny=0\nw=1\nh=1\n"
        )
    });
    let short = "[[binding]]\noutput=\"key:f\"\n".repeat(10_001);
    for (text, limit) in [
        (
            grids + "[[binding]]\noutput=\"key:f\"\n",
            "more than 10000 regions",
        ),
        (
            format!("schema = 1\nname = \"b\"\n{short}"),
            "more than 10000 bindings",
        ),
        ("#".repeat(2 << 20), "larger than 1 MB"),
    ] {
        fs::write(folder.join("large.toml"), text).expect("written");
        let output = gelpad(folder, &["profile", "check", "./large.toml"], b"");
        assert_eq!(output.status.code(), Some(1));
        assert!(
            said(&output).contains(limit),
            "{limit}: {:.500}",
            said(&output)
        );
    }
}

#[test]
fn a_recording_is_replayed_from_a_pipe() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let bytes = fs::read(SESSION).expect("bytes");
    let direct = gelpad(folder, &["replay", SESSION], b"");
    assert_eq!(direct.status.code(), Some(0), "{}", said(&direct));
    for name in ["-", "/dev/stdin"] {
        let piped = gelpad(folder, &["replay", name], &bytes);
        assert_eq!(piped.status.code(), Some(0), "{}", said(&piped));
        assert!(piped.stdout == direct.stdout, "{name}");
    }
    let export = ["export", "-", "--format", "csv", "-o", "frames.csv"];
    let piped = gelpad(folder, &export, &bytes);
    assert_eq!(piped.status.code(), Some(0), "{}", said(&piped));
    let empty = gelpad(folder, &["replay", "-"], b"");
    assert_eq!(empty.status.code(), Some(1));
    assert!(said(&empty).contains("stdin"), "{}", said(&empty));
}

#[test]
fn times_in_seconds_are_noticed() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let header: Vec<String> = (0..208).map(|channel| format!("v{channel}")).collect();
    for (step, is_noticed) in [(0.01, true), (10.0, false), (1.0, false)] {
        let mut text = format!("t_ms,{}\n", header.join(","));
        for frame in 0..40 {
            let volts: Vec<String> = (0..208)
                .map(|v| format!("{}", 1.0 + 0.01 * f64::from(v)))
                .collect();
            let _ = writeln!(text, "{},{}", f64::from(frame) * step, volts.join(","));
        }
        fs::write(folder.join("frames.csv"), text).expect("written");
        let output = gelpad(folder, &["replay", "frames.csv"], b"");
        let noticed = said(&output).contains("are its times seconds?");
        assert_eq!(noticed, is_noticed, "{step}: {}", said(&output));
    }
}

/// A board that was unplugged for a while has the frame rate that it has while it sends.
#[test]
fn time_without_frames_is_no_part_of_the_frame_rate() {
    const AWAY_MS: f64 = 3500.0;
    const FRAMES: usize = 60;
    let folder = tempfile::tempdir().expect("a folder");
    let session = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/data/lattice-presses/session.csv"
    );
    let session = fs::read_to_string(session).expect("a session");
    let mut lines = session.lines();
    let mut text = format!("{}\n", lines.next().expect("a header"));
    for (index, line) in lines.take(2 * FRAMES).enumerate() {
        let (t_ms, volts) = line.split_once(',').expect("a time");
        let away_ms = if index < FRAMES { 0.0 } else { AWAY_MS };
        let t_ms = t_ms.parse::<f64>().expect("a number") + away_ms;
        let _ = writeln!(text, "{t_ms},{volts}");
    }
    fs::write(folder.path().join("s.csv"), text).expect("written");
    let arguments = [
        "play",
        "--source",
        "replay:s.csv",
        "--output",
        "trace",
        "--headless",
    ];
    let said = said(&gelpad(folder.path(), &arguments, b""));
    let sent = format!("{} frames,", 2 * FRAMES);
    assert!(said.contains(&sent), "{said}");
    assert!(
        said.contains(" 100 frames/s\nShortest press detected: 20 ms"),
        "{said}"
    );
}
