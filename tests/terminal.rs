//! The terminal of `gelpad play`: keys of the live view, and its end. A closed terminal releases all keys and ends the
//! game with exit code 129, even where it sends no SIGHUP: the terminals here control no session.

#![cfg(unix)]
#![allow(
    clippy::disallowed_methods,
    reason = "the time until the end is limited"
)]

use std::fs::{self, File};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::os::fd::OwnedFd;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};

/// Longest time from the end of the terminal to the end of the game.
const LONGEST_END: Duration = Duration::from_secs(2);
/// The same if nobody reads what the game writes: the waits for terminal and output are limited.
const STALLED_END: Duration = Duration::from_secs(30);
/// Longest time until the pad is solved and pressed.
const PATIENCE: Duration = Duration::from_secs(120);
/// How the live view marks a binding whose key is down.
const HELD: &str = "■";

/// A pseudo-terminal of 100 x 40 characters: the side of the emulator, and that of programs.
fn terminal() -> (File, File) {
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
    let emulator = openpt(flags).expect("a pseudo-terminal");
    grantpt(&emulator).expect("granted");
    unlockpt(&emulator).expect("unlocked");
    let size = Winsize {
        ws_row: 40,
        ws_col: 100,
        ws_xpixel: 0,
        ws_ypixel: 0,
    };
    tcsetwinsize(&emulator, size).expect("a size");
    let path = ptsname(&emulator, Vec::new()).expect("a name");
    let path = path.to_str().expect("text").to_owned();
    let flags = rustix::fs::OFlags::RDWR | rustix::fs::OFlags::NOCTTY | rustix::fs::OFlags::CLOEXEC;
    let program = rustix::fs::open(path, flags, rustix::fs::Mode::empty()).expect("opened");
    (File::from(emulator), File::from(program))
}

fn stdio(terminal: &File) -> Stdio {
    let copy = terminal.try_clone().expect("a copy");
    Stdio::from(OwnedFd::from(copy))
}

/// A game in which one finger stays down.
fn game(folder: &Path, more: &[&str]) -> Command {
    let script = folder.join("hold.txt");
    fs::write(&script, "t:150 down 1 80 50\nt:60000 end\n").expect("a script");
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelpad"));
    command
        .args(["play", "--output", "trace", "--source"])
        .arg(format!("simulated:{}", script.display()))
        .args(more)
        .env("TERM", "xterm")
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("RUST_LOG");
    command
}

/// Waits for the end of a game.
fn exit_code(mut child: Child, longest: Duration) -> Option<i32> {
    let start = Instant::now();
    while start.elapsed() < longest {
        if let Some(status) = child.try_wait().expect("waited") {
            return status.code();
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().expect("our own child");
    child.wait().expect("ended");
    panic!("the game plays on after {longest:?}");
}

/// Starts a game with a live view and waits until it shows a press.
fn with_live_view(folder: &Path, more: &[&str]) -> (File, Child) {
    let (mut emulator, program) = terminal();
    let child = game(folder, more)
        .stdin(stdio(&program))
        .stdout(stdio(&program))
        .stderr(stdio(&program))
        .spawn()
        .expect("started");
    drop(program);
    let start = Instant::now();
    let mut screen = Vec::new();
    while !String::from_utf8_lossy(&screen).contains(HELD) {
        assert!(start.elapsed() < PATIENCE, "no press is shown");
        let mut fds = [PollFd::new(&emulator, PollFlags::IN)];
        let wait = Timespec {
            tv_sec: 1,
            tv_nsec: 0,
        };
        if poll(&mut fds, Some(&wait)).expect("polled") == 0 {
            continue;
        }
        let mut bytes = [0; 4096];
        let count = emulator.read(&mut bytes).expect("the program runs");
        screen.extend(&bytes[..count]);
    }
    (emulator, child)
}

#[test]
fn a_closed_terminal_ends_a_game_without_a_live_view() {
    let folder = tempfile::tempdir().expect("a folder");
    let (emulator, program) = terminal();
    let mut child = game(folder.path(), &["--headless"])
        .stdin(stdio(&program))
        .stdout(Stdio::piped())
        .stderr(stdio(&program))
        .spawn()
        .expect("started");
    drop(program);
    let mut lines = BufReader::new(child.stdout.take().expect("piped"));
    let mut line = String::new();
    lines.read_line(&mut line).expect("a line");
    assert!(line.ends_with("press key:f\n"), "{line}");
    drop(emulator);
    assert_eq!(exit_code(child, LONGEST_END), Some(129));
    line.clear();
    lines.read_line(&mut line).expect("a line");
    assert!(line.ends_with("release key:f\n"), "{line}");
}

#[test]
fn a_closed_terminal_ends_a_live_view_and_the_recording_holds_the_release() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("session.mcap").display().to_string();
    let (emulator, child) = with_live_view(folder.path(), &["--record", &recording]);
    drop(emulator);
    assert_eq!(exit_code(child, LONGEST_END), Some(129));
    let replayed = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .args(["replay", &recording, "--expect", &recording])
        .args(["--print", "events"])
        .output()
        .expect("started");
    let events = String::from_utf8_lossy(&replayed.stdout);
    assert_eq!(replayed.status.code(), Some(0), "{replayed:?}");
    for action in ["press key:f", "release key:f"] {
        assert!(events.contains(action), "{events}");
    }
}

/// Sends SIGTERM and waits for the end, which a stopped reader must not hold up for long.
fn terminate(child: Child) {
    let process = rustix::process::Pid::from_child(&child);
    rustix::process::kill_process(process, rustix::process::Signal::TERM).expect("sent");
    assert_eq!(exit_code(child, STALLED_END), Some(143));
}

#[test]
fn the_first_signal_ends_a_game_whose_terminal_is_not_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let (emulator, child) = with_live_view(folder.path(), &[]);
    // Nothing is read from here on: the live view fills the terminal's buffer.
    std::thread::sleep(Duration::from_secs(2));
    terminate(child);
    drop(emulator);
}

#[test]
fn the_first_signal_ends_a_game_whose_pipes_are_not_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let full_pipe = || {
        let (reader, writer) = rustix::pipe::pipe().expect("a pipe");
        let flags = rustix::fs::OFlags::NONBLOCK;
        rustix::fs::fcntl_setfl(&writer, flags).expect("set");
        while rustix::io::write(&writer, &[b'\n'; 4096]).is_ok() {}
        while rustix::io::write(&writer, b"\n").is_ok() {}
        rustix::fs::fcntl_setfl(&writer, rustix::fs::OFlags::empty()).expect("set");
        (reader, writer)
    };
    let (events, stdout) = full_pipe();
    let (messages, stderr) = full_pipe();
    let child = game(folder.path(), &["--headless"])
        .stdin(Stdio::null())
        .stdout(Stdio::from(stdout))
        .stderr(Stdio::from(stderr))
        .spawn()
        .expect("started");
    // Long enough for the press, which cannot be written.
    std::thread::sleep(Duration::from_secs(3));
    terminate(child);
    drop((events, messages));
}

#[test]
fn keys_of_the_live_view_end_the_game() {
    let folder = tempfile::tempdir().expect("a folder");
    for (key, code) in [(b"q", 0), (b"\x03", 130)] {
        let (mut emulator, child) = with_live_view(folder.path(), &[]);
        // An emulator that reads nothing would block the drawing.
        let mut screen = emulator.try_clone().expect("a copy");
        std::thread::spawn(move || std::io::copy(&mut screen, &mut std::io::sink()));
        // An arrow key is no Esc.
        emulator.write_all(b"\x1b[A").expect("written");
        std::thread::sleep(Duration::from_millis(100));
        emulator.write_all(key).expect("written");
        assert_eq!(exit_code(child, LONGEST_END), Some(code));
    }
}
