//! Outputs replace nothing but regular files, and never the file that is read. What is cached survives what happens to it.

#![cfg(unix)]

#[path = "outputs/cache.rs"]
mod cache;

use std::fs;
use std::os::unix::fs::{FileTypeExt as _, symlink};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use rustix::fs::{CWD, FileType, Mode, mknodat};

const RECORDINGS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/recordings");

/// A folder with a copy of the recording of format version 1.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["version-1.mcap", "strip-pad.toml", "strip.toml"] {
        fs::copy(Path::new(RECORDINGS).join(name), folder.path().join(name)).expect("copied");
    }
    folder
}

fn gelpad(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelpad"));
    command
        .args(arguments)
        .current_dir(folder)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .stdin(Stdio::null());
    command
}

fn ends(folder: &Path, arguments: &[&str], code: i32) -> Output {
    let output = gelpad(folder, arguments).output().expect("gelpad starts");
    assert_eq!(output.status.code(), Some(code), "{}", said(&output));
    output
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn export<'a>(to: &'a str, format: &'a str) -> [&'a str; 6] {
    ["export", "version-1.mcap", "--format", format, "-o", to]
}

/// Plays `touches.txt` of the folder; the recording's name follows.
const PLAY_AND_RECORD: [&str; 10] = [
    "play",
    "./strip.toml",
    "--pad",
    "./strip-pad.toml",
    "--source",
    "simulated:touches.txt",
    "--output",
    "trace",
    "--headless",
    "--record",
];

#[test]
fn the_input_is_never_overwritten() {
    let folder = folder();
    let folder = folder.path();
    symlink("version-1.mcap", folder.join("link.mcap")).expect("a link");
    fs::copy(folder.join("version-1.mcap"), folder.join("events")).expect("copied");
    let before = fs::read(folder.join("version-1.mcap")).expect("bytes");
    let input = "version-1.mcap";
    for arguments in [
        &export(input, "csv")[..],
        &export("./version-1.mcap", "fm2"),
        &export("link.mcap", "evemu"),
        &["replay", input, "--update", input],
        &["replay", input, "--junit", "link.mcap"],
        &["recover", input, "-o", input],
    ] {
        let output = ends(folder, arguments, 1);
        assert!(said(&output).contains("help: "), "{}", said(&output));
        let after = fs::read(folder.join(input)).expect("bytes");
        assert!(before == after, "{arguments:?} changed its input");
    }
}

#[test]
fn devices_and_pipes_are_written_to_and_stay() {
    let folder = folder();
    let folder = folder.path();
    // A full device refuses the bytes.
    for arguments in [
        &export("/dev/full", "csv")[..],
        &export("/dev/full", "fm2"),
        &["replay", "version-1.mcap", "--update", "/dev/full"],
        &["recover", "version-1.mcap", "-o", "/dev/full"],
    ] {
        let output = ends(folder, arguments, 1);
        assert!(said(&output).contains("/dev/full"), "{}", said(&output));
        let kind = fs::metadata("/dev/full").expect("still there").file_type();
        assert!(kind.is_char_device());
    }
    ends(folder, &export("/dev/null", "csv"), 0);
    let pipe = folder.join("pipe");
    mknodat(CWD, &pipe, FileType::Fifo, Mode::from_raw_mode(0o600), 0).expect("a pipe");
    let child = gelpad(folder, &export("pipe", "csv")).spawn();
    let mut child = child.expect("gelpad starts");
    let text = fs::read_to_string(&pipe).expect("read");
    assert!(text.starts_with("t_ms,v0,"), "{text:.40}");
    assert!(child.wait().expect("ended").success());
    let kind = fs::symlink_metadata(&pipe).expect("still there");
    assert!(kind.file_type().is_fifo());
}

#[test]
fn a_dash_is_standard_output() {
    let folder = folder();
    let folder = folder.path();
    let file = folder.join("frames.csv");
    ends(folder, &export("frames.csv", "csv"), 0);
    let expected = fs::read_to_string(&file).expect("text");
    for to in ["-", "/dev/stdout"] {
        let output = ends(folder, &export(to, "csv"), 0);
        assert_eq!(String::from_utf8_lossy(&output.stdout), expected);
        // Into a file, after what stands in it.
        let target = folder.join("target");
        fs::write(&target, "before\n").expect("written");
        let append = fs::File::options().append(true).open(&target);
        let status = gelpad(folder, &export(to, "csv"))
            .stdout(append.expect("opened"))
            .status();
        assert!(status.expect("gelpad starts").success());
        let text = fs::read_to_string(&target).expect("text");
        assert_eq!(text, format!("before\n{expected}"));
    }
    let output = ends(folder, &["recover", "version-1.mcap", "-o", "-"], 0);
    fs::write(folder.join("copy.mcap"), &output.stdout).expect("written");
    let same = ["replay", "copy.mcap", "--expect", "version-1.mcap"];
    ends(folder, &same, 0);
}

#[test]
fn part_files_follow_no_link_and_are_removed() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("precious"), "precious").expect("written");
    symlink("precious", folder.join("frames.csv.part")).expect("a link");
    ends(folder, &export("frames.csv", "csv"), 0);
    let precious = fs::read_to_string(folder.join("precious")).expect("text");
    assert_eq!(precious, "precious");
    // An export that fails leaves nothing.
    fs::write(folder.join("damaged.mcap"), "no recording").expect("written");
    let damaged = [
        "export",
        "damaged.mcap",
        "--format",
        "csv",
        "-o",
        "none.csv",
    ];
    ends(folder, &damaged, 1);
    let left = fs::read_dir(folder).expect("read").flatten();
    let left: Vec<_> = left.map(|entry| entry.file_name()).collect();
    assert!(
        left.iter()
            .all(|name| !name.to_string_lossy().ends_with(".part") && name != "none.csv"),
        "{left:?}"
    );
}

#[test]
fn a_recording_replaces_no_file_without_force() {
    let folder = folder();
    let folder = folder.path();
    fs::write(
        folder.join("touches.txt"),
        "t:100 down 1 10 10\nt:200 up 1\n",
    )
    .expect("written");
    let record =
        |to: &[&'static str], code| ends(folder, &[&PLAY_AND_RECORD[..], to].concat(), code);
    fs::write(folder.join("s.mcap"), "precious").expect("written");
    let output = record(&["s.mcap"], 1);
    assert!(said(&output).contains("--force"), "{}", said(&output));
    let precious = fs::read_to_string(folder.join("s.mcap")).expect("text");
    assert_eq!(precious, "precious");
    symlink("nowhere", folder.join("dangling.mcap")).expect("a link");
    record(&["dangling.mcap"], 1);
    assert!(!folder.join("nowhere").exists());
    for device in ["/dev/full", "/dev/null"] {
        record(&[device, "--force"], 1);
    }
    record(&["s.mcap", "--force"], 0);
    let itself = ["replay", "s.mcap", "--expect", "s.mcap"];
    ends(folder, &itself, 0);
    // While another gelpad records, even --force is refused.
    fs::write(folder.join("long.txt"), "t:100 down 1 10 10\nt:60000 end\n").expect("written");
    let long = PLAY_AND_RECORD.map(|word| match word {
        "simulated:touches.txt" => "simulated:long.txt",
        word => word,
    });
    let mut first = gelpad(folder, &[&long[..], &["two.mcap"]].concat())
        .stdout(Stdio::null())
        .spawn()
        .expect("gelpad starts");
    let length = || fs::metadata(folder.join("two.mcap")).map_or(0, |file| file.len());
    // Setup and table come first; then long enough for the ten frames of the reference.
    let start = length();
    while length() == start {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    std::thread::sleep(std::time::Duration::from_secs(3));
    let output = record(&["two.mcap", "--force"], 1);
    first.kill().expect("killed");
    first.wait().expect("ended");
    assert!(
        said(&output).contains("another gelpad"),
        "{}",
        said(&output)
    );
    // The first recording is still there.
    let output = gelpad(folder, &["replay", "two.mcap"]).output();
    assert_eq!(output.expect("gelpad starts").status.code(), Some(0));
}

#[test]
fn a_slim_recording_names_matrix_and_table_and_replays_exactly_here() {
    let folder = folder();
    let folder = folder.path();
    fs::write(
        folder.join("touches.txt"),
        "t:300 down 1 80 6\nt:450 up 1\n",
    )
    .expect("written");
    ends(folder, &[&PLAY_AND_RECORD[..], &["whole.mcap"]].concat(), 0);
    ends(
        folder,
        &[&PLAY_AND_RECORD[..], &["slim.mcap", "--slim"]].concat(),
        0,
    );
    let length = |name| fs::metadata(folder.join(name)).expect("there").len();
    let (whole, slim) = (length("whole.mcap"), length("slim.mcap"));
    assert!(slim * 4 < whole, "{slim} of {whole} bytes");
    ends(folder, &["replay", "slim.mcap", "--expect", "slim.mcap"], 0);
    ends(folder, &["recover", "slim.mcap", "-o", "saved.mcap"], 0);
    ends(
        folder,
        &["replay", "saved.mcap", "--expect", "saved.mcap"],
        0,
    );
}

/// A kill at any moment of a slim session costs nothing that was written, and where the copy has no room, no part of it is left.
#[test]
fn a_killed_slim_recording_is_saved_whole_or_not_at_all() {
    let folder = folder();
    let folder = folder.path();
    let presses = (3..600).map(|press| {
        let (down, up) = (100 * press, 100 * press + 60);
        format!("t:{down} down 1 80 6\nt:{up} up 1\n")
    });
    fs::write(folder.join("touches.txt"), presses.collect::<String>()).expect("written");
    let mut play = gelpad(
        folder,
        &[&PLAY_AND_RECORD[..], &["slim.mcap", "--slim"]].concat(),
    )
    .stdout(Stdio::null())
    .stderr(Stdio::null())
    .spawn()
    .expect("gelpad starts");
    let events = || {
        let bytes = fs::read(folder.join("slim.mcap")).unwrap_or_default();
        bytes
            .windows(8)
            .filter(|word| word == b"\"press\",")
            .count()
    };
    while events() < 3 {
        assert!(
            play.try_wait().expect("a process").is_none(),
            "it ended early"
        );
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    play.kill().expect("killed");
    play.wait().expect("ended");
    let before = fs::read(folder.join("slim.mcap")).expect("bytes");
    let recover = format!(
        "trap '' XFSZ; ulimit -f 4; exec '{}' recover slim.mcap -o saved.mcap",
        env!("CARGO_BIN_EXE_gelpad")
    );
    let full = Command::new("bash")
        .args(["-c", &recover])
        .current_dir(folder)
        .output()
        .expect("bash starts");
    assert_eq!(full.status.code(), Some(1), "{}", said(&full));
    assert!(said(&full).contains("cannot be written"), "{}", said(&full));
    assert!(!folder.join("saved.mcap").exists());
    let saved = gelpad(folder, &["recover", "slim.mcap", "-o", "saved.mcap"])
        .output()
        .expect("gelpad starts");
    assert!(
        matches!(saved.status.code(), Some(0 | 3)),
        "{}",
        said(&saved)
    );
    assert_eq!(fs::read(folder.join("slim.mcap")).expect("bytes"), before);
    ends(
        folder,
        &["replay", "saved.mcap", "--expect", "saved.mcap"],
        0,
    );
}
