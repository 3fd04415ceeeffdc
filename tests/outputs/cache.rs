//! The cache of solved pads: starts share it, are killed over it and find it full, and each touch is the same as without it.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use gelpad::cache;

const PRESSES: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/tests/data/lattice-presses/static.csv"
);
const TOUCHES: [&str; 4] = ["replay", PRESSES, "--print", "touches"];

/// Prints the touches of a recording, with this cache.
fn touches(cache: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelpad"));
    command
        .args(TOUCHES)
        .env(cache::FOLDER_VARIABLE, cache)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// What was printed, of a command that succeeded; and what was said.
fn ended(output: Output) -> (String, String) {
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    let printed = String::from_utf8(output.stdout).expect("text");
    assert!(printed.lines().count() > 10, "{printed}");
    (printed, said)
}

fn run(cache: &Path) -> (String, String) {
    ended(touches(cache).output().expect("gelpad starts"))
}

/// The files of a cache.
fn files(cache: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(cache).expect("a folder");
    entries
        .map(|entry| entry.expect("an entry").path())
        .collect()
}

#[test]
fn starts_at_the_same_time_share_a_cache_and_agree() {
    let folder = tempfile::tempdir().expect("a folder");
    let cache = folder.path().join("cache");
    let start = |language: &str| {
        let mut command = touches(&cache);
        command
            .env("LC_ALL", language)
            .spawn()
            .expect("gelpad starts")
    };
    // A comma as the decimal point, and letters that lose their case in another way: neither changes a key or a file.
    let starts = ["C", "de_DE.UTF-8", "tr_TR.UTF-8"].map(start);
    let printed = starts.map(|child| ended(child.wait_with_output().expect("ended")).0);
    assert!(printed[0] == printed[1] && printed[0] == printed[2]);
    assert_eq!(files(&cache).len(), 2, "{:?}", files(&cache));
    let (again, said) = run(&cache);
    assert_eq!(again, printed[0]);
    assert!(!said.contains("solv"), "{said}");
}

#[test]
fn a_start_that_is_killed_while_it_solves_leaves_nothing_that_the_next_one_reads() {
    let folder = tempfile::tempdir().expect("a folder");
    let cache = folder.path().join("cache");
    let mut killed = touches(&cache).spawn().expect("gelpad starts");
    let mut said = BufReader::new(killed.stderr.take().expect("piped"));
    let mut first = String::new();
    said.read_line(&mut first).expect("text");
    assert!(first.contains("solving"), "{first}");
    killed.kill().expect("running");
    killed.wait().expect("ended");
    let (printed, _) = run(&cache);
    assert_eq!(run(&cache).0, printed);
}

#[test]
fn a_full_disk_costs_the_time_of_the_next_start_and_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let (full, whole) = (folder.path().join("full"), folder.path().join("whole"));
    // A table has some megabytes; of a file, half of one can be written, then writing fails as on a full disk.
    let limited = "trap '' XFSZ; ulimit -f 1000; exec \"$0\" \"$@\"";
    let output = Command::new("sh")
        .args(["-c", limited, env!("CARGO_BIN_EXE_gelpad")])
        .args(TOUCHES)
        .env(cache::FOLDER_VARIABLE, &full)
        .output();
    let (printed, said) = ended(output.expect("a shell"));
    assert!(said.contains("solved again at the next start"), "{said}");
    assert_eq!(files(&full), [] as [PathBuf; 0]);
    assert_eq!(run(&whole).0, printed);
}
