//! The command line: messages and exit codes.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};

fn gelpad(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelpad"));
    // No display: the tests must not type into a desktop.
    command
        .args(arguments)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("RUST_LOG");
    command.stdin(Stdio::null());
    command
}

fn run(arguments: &[&str]) -> (i32, String, String) {
    let Output {
        status,
        stdout,
        stderr,
    } = gelpad(arguments).output().expect("started");
    (
        status.code().expect("no signal"),
        String::from_utf8(stdout).expect("text"),
        String::from_utf8(stderr).expect("text"),
    )
}

fn session() -> String {
    format!(
        "{}/tests/data/lattice-presses/session.csv",
        env!("CARGO_MANIFEST_DIR")
    )
}

#[test]
fn own_pads_are_listed_and_those_with_mistakes_too() {
    let home = tempfile::tempdir().expect("a folder");
    let pads = home.path().join("gelpad/pads");
    std::fs::create_dir_all(&pads).expect("a folder");
    let (_, toml, _) = run(&["pad", "show", "round-tank", "--toml"]);
    std::fs::write(pads.join("bowl.toml"), toml).expect("written");
    std::fs::write(pads.join("torn.toml"), "schema = ").expect("written");
    let listed = gelpad(&["pad", "list"])
        .env("XDG_CONFIG_HOME", home.path())
        .output()
        .expect("gelpad starts");
    let listed = String::from_utf8(listed.stdout).expect("text");
    let row = |name: &str| listed.lines().find(|line| line.starts_with(name));
    assert!(
        row("bowl").is_some_and(|row| row.ends_with("(yours)")),
        "{listed}"
    );
    assert!(
        row("torn").is_some_and(|row| row.contains("has mistakes")),
        "{listed}"
    );
    assert!(row("edinburgh-lattice").is_some(), "{listed}");
}

#[test]
fn wrong_input_gets_one_clear_message_and_code_1() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("written");
        path.display().to_string()
    };
    let shipped = include_str!("../profiles/super-mario.toml");
    let pad = include_str!("../pads/edinburgh-lattice.toml");
    let row = |value: &str| {
        let header: Vec<String> = (0..208).map(|i| format!("v{i}")).collect();
        let mut values = vec!["1.0"; 208];
        values[7] = value;
        format!("t_ms,{}\n0,{}\n", header.join(","), values.join(","))
    };
    let cases: Vec<(Vec<String>, &str)> = vec![
        (
            vec!["replay".into(), "no-such.csv".into()],
            "no-such.csv: No such file",
        ),
        (
            vec!["replay".into(), file("empty.csv", b"")],
            "empty.csv:1: the file is empty",
        ),
        (
            vec!["replay".into(), file("few.csv", b"t_ms,v0\n0,1\n")],
            "few.csv:1: 1 voltages a frame, but the pad has 208",
        ),
        (
            vec!["replay".into(), file("nan.csv", row("NaN").as_bytes())],
            "nan.csv:2: column 9 (v7): \"NaN\" is not a voltage",
        ),
        (
            vec![
                "replay".into(),
                file("noise.csv", b"\x00\xff\x80\x13\n\xfe\xfe"),
            ],
            "noise.csv:1: ",
        ),
        (
            vec![
                "replay".into(),
                session(),
                "--pad".into(),
                "edinburg-lattice".into(),
            ],
            "did you mean `edinburgh-lattice`?",
        ),
        (
            ["accuracy", "--real", "--only", "no-such", "--out"]
                .map(str::to_owned)
                .into_iter()
                .chain([folder.path().join("out").display().to_string()])
                .collect(),
            "the conditions are:\n  as the model assumes, 60 dB",
        ),
        (
            vec!["play".into(), "super-maria".into()],
            "did you mean `super-mario`?",
        ),
        (
            vec!["play".into(), "./no-such.toml".into()],
            "./no-such.toml: No such file",
        ),
        (
            vec![
                "play".into(),
                file(
                    "key.toml",
                    shipped.replacen("min_gap_ms", "min_gap", 1).as_bytes(),
                ),
            ],
            "unknown key `min_gap` at the top of a profile",
        ),
        (
            vec![
                "play".into(),
                file(
                    "off.toml",
                    shipped.replacen("x = 0.62", "x = 0.72", 1).as_bytes(),
                ),
            ],
            "the region ends at 1.100, off the pad on the right",
        ),
        (
            vec![
                "profile".into(),
                "check".into(),
                file("bytes.toml", b"\xff\xfe\x00"),
            ],
            "bytes.toml: not a text file",
        ),
        (
            vec![
                "pad".into(),
                "check".into(),
                file(
                    "wide.toml",
                    pad.replacen("width_mm = 2.0", "width_mm = 12.0", 1)
                        .as_bytes(),
                ),
            ],
            "channels of 12 mm overlap",
        ),
        (
            vec![
                "play".into(),
                "--source".into(),
                format!("simulated:{}", file("script.txt", b"t:10 down 1 80\n")),
            ],
            "script.txt:1:15: the line ends before y in mm",
        ),
        (
            vec![
                "play".into(),
                "--source".into(),
                "serial:/dev/no-such-port".into(),
            ],
            "/dev/no-such-port: ",
        ),
        (
            vec!["play".into(), "--output".into(), "keyboard".into()],
            "neither WAYLAND_DISPLAY nor DISPLAY is set",
        ),
    ];
    for (arguments, said) in &cases {
        // With access to uinput this output opens.
        if said.starts_with("neither") && Path::new("/dev/uinput").exists() {
            continue;
        }
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let (code, stdout, stderr) = run(&arguments);
        assert_eq!(code, 1, "{arguments:?}: {stderr}");
        assert!(
            stderr.contains(said),
            "{arguments:?}\nsaid {stderr}\nnot  {said}"
        );
        assert!(!stderr.contains("panicked"), "{stderr}");
        assert_eq!(stdout, "", "{arguments:?}");
    }
}

#[test]
fn wrong_arguments_end_with_code_2() {
    for arguments in [
        ["replay", "--print"].as_slice(),
        &["play", "--source", "carrier-pigeon"],
        &["play", "--method", "magic"],
        &["play", "--snr", "-3"],
        &["fly"],
    ] {
        assert_eq!(run(arguments).0, 2, "{arguments:?}");
    }
}

#[test]
fn every_subcommand_has_an_example_in_its_help() {
    for arguments in [
        ["--help"].as_slice(),
        &["play", "--help"],
        &["replay", "--help"],
        &["pad", "--help"],
        &["pad", "show", "--help"],
        &["pad", "check", "--help"],
        &["profile", "--help"],
        &["profile", "show", "--help"],
        &["profile", "check", "--help"],
        &["profile", "schema", "--help"],
        &["profile", "list", "--help"],
        &["pad", "list", "--help"],
        &["recover", "--help"],
        &["export", "--help"],
        &["listen", "--help"],
        &["device", "--help"],
        &["calibrate", "--help"],
        &["study", "--help"],
        &["study", "width", "--help"],
        &["study", "phantoms", "--help"],
        &["study", "thickness", "--help"],
        &["study", "merge", "--help"],
        &["accuracy", "--help"],
        &["doctor", "--help"],
    ] {
        let (code, stdout, _) = run(arguments);
        assert_eq!(code, 0);
        assert!(stdout.contains("Example"), "{arguments:?}\n{stdout}");
    }
}

#[test]
fn printed_texts_can_be_used_as_files() {
    let folder = tempfile::tempdir().expect("a folder");
    for (kind, name) in [("pad", "round-tank"), ("profile", "super-mario")] {
        let (_, toml, _) = run(&[kind, "show", name, "--toml"]);
        let path = folder.path().join(format!("{name}.toml"));
        fs::write(&path, toml).expect("written");
        let (code, stdout, _) = run(&[kind, "check", &path.display().to_string()]);
        assert_eq!(code, 0);
        assert!(stdout.contains("sound"), "{stdout}");
    }
}

#[test]
fn profiles_are_drawn_for_screen_and_printer() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let [svg, png, print] = ["a.svg", "a.png", "b.svg"].map(path);
    let drawn = run(&[
        "profile",
        "show",
        "one-handed",
        "--svg",
        &svg,
        "--png",
        &png,
        "--print",
        &print,
    ]);
    assert_eq!((drawn.0, drawn.1.as_str()), (0, ""), "{}", drawn.2);
    let read = |path: &str| fs::read_to_string(path).expect("drawn");
    assert!(read(&svg).contains(">jump</text>"));
    assert!(fs::read(&png).expect("drawn").starts_with(b"\x89PNG"));
    // One unit of the drawing is 1 mm; the region of this profile is 50 mm wide.
    let sheet = read(&print);
    assert!(
        sheet.contains("width=\"210mm\" height=\"297mm\" viewBox=\"0 0 210 297\""),
        "{sheet}"
    );
    assert!(
        sheet.contains("width=\"100\" height=\"100\" fill=\"none\""),
        "the pad's outline"
    );
    assert!(
        sheet.contains("<polygon points=\"80.00,105.00 130.00,105.00"),
        "`down`: from 25 to 75 mm of the pad"
    );
    let (code, _, stderr) = run(&["profile", "show", "--print", "/no-such-folder/a.svg"]);
    assert_eq!(code, 1);
    assert!(
        stderr.contains("/no-such-folder/a.svg cannot be written"),
        "{stderr}"
    );
}

#[test]
fn show_names_the_text_of_each_value_of_a_profile_with_user_settings() {
    let folder = tempfile::tempdir().expect("a folder");
    let user = folder.path().join("anna.toml");
    fs::write(&user, "slow_keys_ms = 80\nreach_w = 0.5\n").expect("written");
    let user = user.display().to_string();
    let (code, stdout, stderr) = run(&["profile", "check", "super-mario", "--user", &user]);
    assert_eq!(code, 0, "{stderr}");
    assert!(
        stdout.contains("sound") && stdout.contains("warnings"),
        "{stdout}"
    );
    assert!(
        stderr.contains("the region `jump` is out of reach"),
        "{stderr}"
    );
    let (_, stdout, _) = run(&["profile", "show", "one-handed", "--user", &user]);
    for line in [
        ("slow_keys_ms = 80", "anna.toml"),
        ("area_x = 0.25", "one-handed"),
        ("min_gap_ms = 34", "super-mario"),
    ] {
        let told = stdout
            .lines()
            .any(|text| text.contains(line.0) && text.ends_with(line.1));
        assert!(told, "{line:?} in\n{stdout}");
    }
    let (code, _, stderr) = run(&["profile", "check", "super-mario", "--user", "tremro"]);
    assert_eq!(code, 1);
    let known = "no settings called `tremro`; known: tremor, light-touch";
    assert!(stderr.contains(known), "{stderr}");
    assert!(stderr.contains("did you mean `tremor`?"), "{stderr}");
}

#[test]
fn without_a_terminal_the_level_prints_its_events_and_a_summary() {
    let (code, stdout, stderr) = run(&[]);
    assert_eq!(code, 0, "{stderr}");
    let presses = stdout
        .lines()
        .filter(|line| line.contains(" press "))
        .count();
    let releases = stdout
        .lines()
        .filter(|line| line.contains(" release "))
        .count();
    assert_eq!((presses, releases), (13, 13), "{stdout}");
    assert!(stderr.contains("1001 frames, 13 presses"), "{stderr}");
}

#[test]
fn a_recorded_session_plays_in_real_time_to_its_end() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("short.csv");
    let text = fs::read_to_string(session()).expect("the session");
    let head: String = text
        .lines()
        .take(200)
        .map(|line| format!("{line}\n"))
        .collect();
    fs::write(&path, head).expect("written");
    let source = format!("replay:{}", path.display());
    let (code, stdout, stderr) = run(&[
        "play",
        "--source",
        &source,
        "--output",
        "trace",
        "--headless",
    ]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stdout.contains("press key:f"), "{stdout}");
}

#[test]
fn a_closed_stdout_ends_quietly() {
    // The first use of a pad says that its table is solved.
    let first = gelpad(&["replay", &session()]).output().expect("started");
    assert!(first.status.success());
    let mut child = gelpad(&["replay", &session(), "--print", "touches"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("ended");
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

/// Starts a game in which one finger stays down; returns its first event line.
fn game_with_a_held_key(folder: &Path) -> (Child, BufReader<std::process::ChildStdout>, String) {
    let script = folder.join("hold.txt");
    let mut file = fs::File::create(&script).expect("a script");
    writeln!(file, "t:150 down 1 80 50\nt:60000 end").expect("written");
    let source = format!("simulated:{}", script.display());
    let mut child = gelpad(&[
        "play",
        "--source",
        &source,
        "--output",
        "trace",
        "--headless",
    ])
    .stdout(Stdio::piped())
    .stderr(Stdio::null())
    .spawn()
    .expect("started");
    let mut lines = BufReader::new(child.stdout.take().expect("piped"));
    let mut first = String::new();
    lines.read_line(&mut first).expect("a line");
    (child, lines, first)
}

#[test]
fn signals_release_all_keys_and_end_with_their_code() {
    for (signal, code) in [
        (Signal::INT, 130),
        (Signal::TERM, 143),
        (Signal::HUP, 129),
        (Signal::QUIT, 131),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let (mut child, mut lines, first) = game_with_a_held_key(folder.path());
        assert!(first.ends_with("press key:f\n"), "{first}");
        std::thread::sleep(Duration::from_millis(100));
        let pid = Pid::from_child(&child);
        kill_process(pid, signal).expect("our own child");
        let mut rest = String::new();
        lines.read_line(&mut rest).expect("a line");
        assert!(rest.ends_with("release key:f\n"), "{rest}");
        assert_eq!(child.wait().expect("ended").code(), Some(code));
    }
}

/// Root may raise its threads, so the capability is taken away first, which other users have not got.
#[cfg(target_os = "linux")]
#[test]
fn without_the_right_to_raise_threads_realtime_kit_is_asked() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().expect("a folder");
    let touches = folder.path().join("touches.txt");
    fs::write(&touches, "t:300 down 1 80 30\nt:400 up 1\n").expect("written");
    let asked = folder.path().join("asked");
    let tool = folder.path().join("busctl");
    let script = format!("#!/bin/sh\necho \"$*\" >>{}\n", asked.display());
    fs::write(&tool, script).expect("written");
    fs::set_permissions(&tool, fs::Permissions::from_mode(0o700)).expect("ours");
    let path = std::env::var("PATH").expect("a path");
    let mut gelpad = Command::new("setpriv")
        .args(["--bounding-set=-sys_nice", "--inh-caps=-sys_nice"])
        .arg(env!("CARGO_BIN_EXE_gelpad"))
        .args(["play", "--source"])
        .arg(format!("simulated:{}", touches.display()))
        .args(["--output", "trace", "--headless"])
        .env("PATH", format!("{}:{path}", folder.path().display()))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("setpriv of util-linux");
    let pid = gelpad.id();
    assert!(gelpad.wait().expect("ended").success());
    let asked = fs::read_to_string(asked).expect("something was asked");
    let wanted = format!("MakeThreadHighPriorityWithPID tti {pid} ");
    let mut threads: Vec<&str> = asked
        .lines()
        .map(|line| line.split_once(&wanted).expect("the method").1)
        .collect();
    threads.sort_unstable();
    threads.dedup();
    // Source, engine and output.
    assert_eq!(threads.len(), 3, "{asked}");
    assert!(
        threads.iter().all(|thread| thread.ends_with(" -- -10")),
        "{asked}"
    );
}
