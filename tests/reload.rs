//! Hot reload: saved profiles are played, with real files and the binary.

#![allow(
    clippy::disallowed_methods,
    reason = "the time from a save to its being played is measured"
)]

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest time from saving a profile to playing it.
const LONGEST: Duration = Duration::from_secs(2);
const SAVES: usize = 20;

fn profile(key: &str) -> String {
    format!(
        "schema = 1\nname = \"{key}\"\n[[region]]\nname = \"pad\"\nx = 0\ny = 0\nw = 1\nh = 1\n[[binding]]\nregion = \"pad\"\noutput = \"key:{key}\"\n"
    )
}

/// Plays a script with the profile `mine.toml` of a folder; returns its stderr.
fn play(folder: &Path, script: &str, more: &[&str]) -> (Child, BufReader<ChildStderr>) {
    let touches = folder.join("touches.txt");
    fs::write(&touches, script).expect("written");
    let mut child = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .arg("play")
        .arg(folder.join("mine.toml"))
        .arg("--source")
        .arg(format!("simulated:{}", touches.display()))
        .args(["--output", "trace", "--headless"])
        .args(more)
        .env("XDG_CONFIG_HOME", folder)
        .env_remove("DISPLAY")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    let stderr = BufReader::new(child.stderr.take().expect("piped"));
    (child, stderr)
}

/// Reads lines until one contains a text; returns all of them.
fn wait_for(stderr: &mut BufReader<ChildStderr>, expected: &str) -> String {
    let mut said = String::new();
    loop {
        let mut line = String::new();
        let read = stderr.read_line(&mut line).expect("a line");
        assert!(read > 0, "ended without `{expected}`; printed\n{said}");
        said.push_str(&line);
        if line.contains(expected) {
            return said;
        }
    }
}

fn save(folder: &Path, text: &str) -> Instant {
    fs::write(folder.join("mine.toml"), text).expect("saved");
    Instant::now()
}

#[test]
fn a_saved_profile_is_played_and_a_broken_one_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    save(folder.path(), &profile("a"));
    let (mut child, mut stderr) = play(
        folder.path(),
        "t:300 down 1 50 50\nt:400 up 1\nt:60000 end\n",
        &[],
    );
    // Wait for the first key, then time every save.
    let mut stdout = BufReader::new(child.stdout.take().expect("piped"));
    let mut line = String::new();
    stdout.read_line(&mut line).expect("an event");
    assert!(line.ends_with("press key:a\n"), "{line}");
    let mut took: Vec<Duration> = Vec::new();
    for save_number in 0..SAVES {
        let key = ["b", "c"][save_number % 2];
        let saved = save(folder.path(), &profile(key));
        wait_for(&mut stderr, &format!("playing {key},"));
        took.push(saved.elapsed());
    }
    took.sort();
    let at = |share: f64| took[(share * (took.len() - 1) as f64).round() as usize];
    println!(
        "saved to live: p50 {:?}, p99 {:?} of {SAVES}",
        at(0.5),
        at(0.99)
    );
    assert!(at(1.0) < LONGEST, "{took:?}");
    save(folder.path(), &profile("b").replace("output", "outptu"));
    let said = wait_for(&mut stderr, "did you mean `output`");
    assert!(
        said.contains("the old profile stays") && said.contains("mine.toml:11:1"),
        "{said}"
    );
    save(folder.path(), &profile("d"));
    wait_for(&mut stderr, "playing d,");
    child.kill().expect("our own child");
    child.wait().expect("ended");
}

#[test]
fn a_held_key_is_released_when_the_profile_changes() {
    let folder = tempfile::tempdir().expect("a folder");
    save(folder.path(), &profile("a"));
    let (mut child, mut stderr) = play(folder.path(), "t:300 down 1 50 50\nt:60000 end\n", &[]);
    let mut stdout = BufReader::new(child.stdout.take().expect("piped"));
    let mut line = String::new();
    stdout.read_line(&mut line).expect("an event");
    assert!(line.ends_with("press key:a\n"), "{line}");
    save(folder.path(), &profile("b"));
    wait_for(&mut stderr, "playing b,");
    line.clear();
    stdout.read_line(&mut line).expect("an event");
    assert!(
        line.ends_with("release key:a\n"),
        "the finger never lifted: {line}"
    );
    child.kill().expect("our own child");
    child.wait().expect("ended");
}

#[test]
#[cfg(target_os = "linux")]
fn a_running_program_selects_its_profile() {
    let folder = tempfile::tempdir().expect("a folder");
    save(folder.path(), &profile("a"));
    let own = folder.path().join("gelpad/profiles");
    fs::create_dir_all(&own).expect("made");
    let matched = format!("{}[match]\nprocess = \"gelpad-tester\"\n", profile("b"));
    fs::write(own.join("b.toml"), matched).expect("written");
    let program = folder.path().join("gelpad-tester");
    fs::copy("/bin/sleep", &program).expect("copied");
    let (mut child, mut stderr) = play(
        folder.path(),
        "t:50 down 1 50 50\nt:90 up 1\nt:60000 end\n",
        &["--match"],
    );
    let mut game = Command::new(&program).arg("60").spawn().expect("started");
    wait_for(&mut stderr, "playing b,");
    game.kill().expect("our own child");
    game.wait().expect("ended");
    wait_for(&mut stderr, "playing a,");
    child.kill().expect("our own child");
    child.wait().expect("ended");
}
