//! A session in parts is recorded, replayed to the bit, and exported as frames; rows of frames are read as parts, whatever is wrong
//! with them.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};

fn gelpad(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelpad"));
    command.args(arguments);
    command
}

/// Plays a board that reads its drives in turn, 25 frames a second, into a recording; returns the trace.
fn record(folder: &Path, more: &[&str]) -> String {
    let path = |name: &str| folder.join(name).display().to_string();
    let (port, script, session) = (path("port"), path("touches.txt"), path("session.mcap"));
    std::fs::write(
        &script,
        "t:1500 down 1 80 50\nt:1900 up 1\nt:2300 down 1 80 50\nt:2400 down 2 13 57\nt:2900 up 1\nt:3000 up 2\nt:9000 end",
    )
    .expect("written");
    let mut device = gelpad(&[
        "device", "--format", "lines", "--rate", "25", "--frames", "100",
    ])
    .args(["--script", &script, "--port", &port])
    .stderr(Stdio::null())
    .spawn()
    .expect("started");
    while !Path::new(&port).exists() {
        std::thread::sleep(Duration::from_millis(10));
    }
    let player = gelpad(&["play", "--headless", "--output", "trace"])
        .args(["--source", &format!("serial:{port}"), "--record", &session])
        .args(more)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    assert!(device.wait().expect("ended").success());
    std::thread::sleep(Duration::from_millis(300));
    kill_process(Pid::from_child(&player), Signal::TERM).expect("running");
    let output = player.wait_with_output().expect("ended");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn run(arguments: &[&str]) -> (String, String, Option<i32>) {
    let output = gelpad(arguments).output().expect("started");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (
        text(&output.stdout),
        text(&output.stderr),
        output.status.code(),
    )
}

#[test]
fn a_session_in_parts_replays_to_the_bit_and_gives_its_frames() {
    let folder = tempfile::tempdir().expect("a folder");
    let trace = record(folder.path(), &[]);
    assert!(
        trace
            .lines()
            .filter(|line| line.contains("press key:"))
            .count()
            >= 3,
        "{trace}"
    );
    let session = folder.path().join("session.mcap").display().to_string();
    let (events, said, code) = run(&["replay", &session, "--expect", &session]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(events, "", "nothing is printed when comparing");
    let (events, _, _) = run(&["replay", &session]);
    // On a busy computer keys that do not wait for each other are sent in another order.
    let keys = |text: &str| -> Vec<String> {
        let words = |line: &str| line.split_once(' ').map(|(_, action)| action.to_owned());
        let mut keys: Vec<String> = text.lines().filter_map(words).collect();
        keys.sort_unstable();
        keys
    };
    assert_eq!(keys(&events), keys(&trace));
    // Most frames came in parts; all that were complete are exported.
    let csv = folder.path().join("frames.csv").display().to_string();
    let (_, said, code) = run(&["export", &session, "--format", "csv", "-o", &csv]);
    assert_eq!(code, Some(0), "{said}");
    let rows = std::fs::read_to_string(&csv)
        .expect("written")
        .lines()
        .count();
    assert!((85..=101).contains(&rows), "{rows} rows for 100 frames");
    let (saved, _, code) = run(&[
        "recover",
        &session,
        "-o",
        &folder.path().join("saved.mcap").display().to_string(),
    ]);
    assert_eq!(code, Some(0), "{saved}");
    // Its frames play again, in parts as they came.
    let source = format!("replay:{session}");
    let (again, said, _) = run(&[
        "play",
        "--source",
        &source,
        "--output",
        "trace",
        "--headless",
    ]);
    // On a busy computer keys were released between two parts that came late, and pressed again; a file has no such pause.
    let played = [
        "press key:f",
        "press key:f",
        "press key:left",
        "release key:f",
        "release key:f",
        "release key:left",
    ];
    assert_eq!(keys(&again), played, "{said}");
}

/// The events of a recorded session whose frames are read drive by drive, after `damage` to its lines.
fn scanned(folder: &Path, damage: impl Fn(usize, &mut [f64])) -> [Vec<String>; 2] {
    let whole = include_str!("../data/lattice-presses/session.csv");
    let damaged: Vec<String> = whole
        .lines()
        .enumerate()
        .map(|(index, line)| match line.split_once(',') {
            Some((t_ms, volts)) if index > 0 => {
                let values = volts.split(',').map(|volt| volt.parse().expect("a number"));
                let mut volts: Vec<f64> = values.collect();
                damage(index, &mut volts);
                let volts: Vec<String> = volts.iter().map(f64::to_string).collect();
                format!("{t_ms},{}", volts.join(","))
            }
            _ => line.to_owned(),
        })
        .collect();
    let file = folder.join("frames.csv");
    std::fs::write(&file, damaged.join("\n")).expect("written");
    let file = file.display().to_string();
    let (events, said, status) = run(&["replay", &file, "--scan", "--print", "events"]);
    assert_eq!(status, Some(0), "{said}");
    ["press", "release"].map(|what| {
        let with = events.lines().filter_map(|line| line.split_once(what));
        with.map(|(_, key)| key.trim().to_owned()).collect()
    })
}

#[test]
fn a_damaged_frame_or_a_reading_that_stays_off_costs_no_press_of_a_frame_in_parts() {
    let folder = tempfile::tempdir().expect("a folder");
    let [presses, releases] = scanned(folder.path(), |_, _| {});
    assert_eq!((presses.len(), releases.len()), (40, 40));
    for factor in [3.0, 0.0, -1.0] {
        let damaged = scanned(folder.path(), |index, volts| {
            if index == 1500 {
                volts.iter_mut().for_each(|volt| *volt *= factor);
            }
        });
        assert_eq!(damaged[0], presses, "one frame times {factor}");
        assert_eq!(damaged[1], releases, "one frame times {factor}");
    }
    // A change that lasts and that no finger explains is asked about ever less often: fingers are found beside it.
    let [pressed, released] = scanned(folder.path(), |index, volts| {
        if index >= 1200 {
            volts[16] *= 1.04;
        }
    });
    assert!((40..=41).contains(&pressed.len()), "{pressed:?}");
    assert_eq!(pressed.len(), released.len(), "no key sticks");
}
