//! A board's pad is identified while it is played, and known the next time.

use std::fmt::Write as _;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::thread::sleep;
use std::time::{Duration, Instant};

use gelpad::cache;
use gelpad::pad::{ElectrodeDeviation, Pad, shipped_pad};
use rustix::process::{Pid, Signal, kill_process};

use crate::{built, drawing, errors};

/// The text of a pad with what deviates.
fn text_of(pad: &Pad) -> String {
    let mut text = shipped_pad("edinburgh-lattice")
        .expect("shipped")
        .toml
        .to_owned();
    let electrodes = &pad.deviations.electrodes;
    let list = |length: fn(&ElectrodeDeviation) -> f64| {
        let lengths: Vec<String> = electrodes.iter().map(|e| length(e).to_string()).collect();
        lengths.join(", ")
    };
    let cells = pad.deviations.cells.iter();
    let cells: Vec<String> = cells
        .map(|([x, y], factor)| format!("[{x:?}, {y:?}, {factor:?}]"))
        .collect();
    let _ = write!(
        text,
        "\n[found]\nshift_mm = [{}]\nstretch_mm = [{}]\nconductance = [{}]\n",
        list(|electrode| electrode.shift_mm),
        list(|electrode| electrode.stretch_mm),
        cells.join(", ")
    );
    text
}

/// A simulated board on a pseudo-terminal; dropping it ends it.
pub struct Board {
    process: Child,
    port: PathBuf,
}

impl Board {
    pub fn start(folder: &Path, pad: &str, script: &str) -> Self {
        Self::with_options(folder, pad, script, &[])
    }

    pub fn with_options(folder: &Path, pad: &str, script: &str, options: &[&str]) -> Self {
        std::fs::write(folder.join("script.txt"), script).expect("written");
        let port = folder.join("board");
        let process = Command::new(env!("CARGO_BIN_EXE_gelpad"))
            .current_dir(folder)
            .args(["device", "--format", "gelpad", "--script", "script.txt"])
            .args(["--pad", pad, "--port", "board"])
            .args(options)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("started");
        while !port.exists() {
            sleep(Duration::from_millis(5));
        }
        Self { process, port }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = std::fs::remove_file(&self.port);
    }
}

#[allow(clippy::disallowed_methods, reason = "times are printed, not tested")]
fn now() -> Instant {
    Instant::now()
}

/// Plays the board with a cache of this test's own until a message contains each of these texts in turn, for at most a minute. Returns
/// the messages.
fn play_until(folder: &Path, more: &[&str], texts: &[&str]) -> Vec<String> {
    let mut game = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .current_dir(folder)
        .env(cache::FOLDER_VARIABLE, folder.join("cache"))
        .args(["play", "--source", "serial:board", "--output", "trace"])
        .args(["--headless"])
        .args(more)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    let stderr = game.stderr.take().expect("piped");
    let (lines_in, lines) = mpsc::sync_channel(1000);
    let reader = std::thread::Builder::new()
        .spawn(move || {
            for line in BufReader::new(stderr).lines().map_while(Result::ok) {
                if lines_in.send(line).is_err() {
                    break;
                }
            }
        })
        .expect("a thread");
    let started = now();
    let mut said = Vec::new();
    let mut awaited = texts.iter();
    let mut next = awaited.next();
    while let Some(text) = next {
        match lines.recv_timeout(Duration::from_secs(60)) {
            Ok(line) => {
                println!("{:.2} s: {line}", started.elapsed().as_secs_f64());
                if line.contains(text) {
                    next = awaited.next();
                }
                said.push(line);
            }
            Err(error) => {
                let _ = game.kill();
                panic!("no `{text}` ({error}) after {said:#?}");
            }
        }
    }
    game.kill().expect("ended");
    let _ = game.wait();
    reader.join().expect("ended");
    said
}

/// The identified pad that a cache keeps.
fn kept_pad(folder: &Path) -> Pad {
    let kept: Vec<PathBuf> = std::fs::read_dir(folder.join("cache"))
        .expect("a cache")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .collect();
    let [path] = kept.as_slice() else {
        panic!("one kept pad: {kept:?}");
    };
    let text = std::fs::read_to_string(path).expect("a text");
    Pad::from_toml("edinburgh-lattice", &text).expect("sound")
}

/// A folder with a pad as built and a cache with the table of the drawing.
pub fn bench() -> (tempfile::TempDir, Pad) {
    let folder = tempfile::tempdir().expect("a folder");
    let drawing = drawing("edinburgh-lattice");
    let table = cache::load_or_solve(&drawing, &|_, _| ()).expect("solvable");
    cache::store(&table, &folder.path().join("cache")).expect("stored");
    let truth = built(&drawing);
    std::fs::write(folder.path().join("built.toml"), text_of(&truth)).expect("written");
    (folder, truth)
}

#[test]
fn a_board_is_identified_in_play_and_known_the_next_time() {
    let (folder, truth) = bench();
    let untouched = "t:60000 down 1 80 50\nt:60100 up 1\nt:60200 end";
    {
        let _board = Board::start(folder.path(), "./built.toml", untouched);
        play_until(folder.path(), &[], &["pad identified: its readings are"]);
        let [cells, shifts] = errors(&kept_pad(folder.path()), &truth);
        assert!(cells < 0.08 && shifts < 0.3, "{cells} {shifts}");
        let said = play_until(folder.path(), &[], &["this pad was identified before"]);
        assert!(!said.concat().contains("pad identified:"), "{said:?}");
    }
    // Another board at the same port, whose pad is as drawn, is played as drawn.
    let _board = Board::start(folder.path(), "edinburgh-lattice", untouched);
    let said = play_until(folder.path(), &["-vv"], &["readings at rest:"]);
    assert!(!said.concat().contains("identified"), "{said:?}");
}

/// Prints what is said and when (`--nocapture`): how long the first use of a board takes, and the second.
#[test]
fn a_board_plays_at_once_from_nothing_is_identified_and_needs_neither_the_next_time() {
    let (folder, _) = bench();
    std::fs::remove_dir_all(folder.path().join("cache")).expect("removed");
    let untouched = "t:60000 down 1 80 50\nt:60100 up 1\nt:60200 end";
    let _board = Board::start(folder.path(), "./built.toml", untouched);
    let in_turn = [
        "first use of this pad",
        "the responses of this pad are solved",
        "pad identified: its readings are",
    ];
    play_until(folder.path(), &[], &in_turn);
    let said = play_until(folder.path(), &[], &["this pad was identified before"]);
    assert!(!said.concat().contains("first use"), "{said:?}");
}

#[test]
fn a_game_that_is_ended_while_its_pad_is_being_solved_leaves_nothing_half_done() {
    let (folder, _) = bench();
    std::fs::remove_dir_all(folder.path().join("cache")).expect("removed");
    let untouched = "t:60000 down 1 80 50\nt:60100 up 1\nt:60200 end";
    let _board = Board::start(folder.path(), "edinburgh-lattice", untouched);
    let start = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gelpad"));
        command
            .current_dir(folder.path())
            .env(cache::FOLDER_VARIABLE, folder.path().join("cache"))
            .args(["play", "--source", "serial:board", "--output", "trace"])
            .arg("--headless")
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        command.spawn().expect("started")
    };
    let mut stopped = start();
    let mut lines = BufReader::new(stopped.stderr.take().expect("piped")).lines();
    let is_solving = |line: std::io::Result<String>| line.is_ok_and(|l| l.contains("first use"));
    assert!(lines.any(is_solving));
    kill_process(Pid::from_child(&stopped), Signal::INT).expect("running");
    let after: Vec<String> = lines.map_while(Result::ok).collect();
    let ending = stopped.wait().expect("ended");
    assert_eq!(ending.code(), Some(130), "{after:?}");
    assert!(
        after.iter().any(|line| line.contains("frames")),
        "{after:?}"
    );
    // The one that was ended has left nothing that the next takes for a table.
    let solved = "the responses of this pad are solved";
    play_until(folder.path(), &[], &["first use", solved]);
    let next = play_until(folder.path(), &["-vv"], &["readings at rest:"]);
    assert!(!next.concat().contains("first use"), "{next:?}");
}

#[test]
fn a_finger_that_lies_on_the_pad_from_the_start_is_not_kept_as_a_part_of_it() {
    let (folder, truth) = bench();
    let lying = "t:0 down 1 30 30\nt:3000 up 1\nt:60000 down 1 80 50\nt:60100 up 1\nt:60200 end";
    let _board = Board::start(folder.path(), "./built.toml", lying);
    let twice = ["pad identified:", "pad identified:"];
    play_until(folder.path(), &[], &twice);
    let [cells, shifts] = errors(&kept_pad(folder.path()), &truth);
    assert!(cells < 0.08 && shifts < 0.3, "{cells} {shifts}");
}

#[test]
fn a_pad_is_identified_without_the_readings_of_a_lost_electrode() {
    let (folder, truth) = bench();
    let untouched = "t:60000 down 1 80 50\nt:60100 up 1\nt:60200 end";
    let lost = ["--lose-electrode", "5"];
    let _board = Board::with_options(folder.path(), "./built.toml", untouched, &lost);
    let said = play_until(folder.path(), &[], &["pad identified: its readings are"]);
    assert!(said.concat().contains("electrode 5 is loose"), "{said:?}");
    let [cells, shifts] = errors(&kept_pad(folder.path()), &truth);
    assert!(cells < 0.12 && shifts < 0.5, "{cells} {shifts}");
}

#[test]
fn a_pad_is_identified_where_nothing_can_be_kept() {
    let (folder, _) = bench();
    std::fs::remove_dir_all(folder.path().join("cache")).expect("removed");
    std::fs::write(folder.path().join("cache"), "a file").expect("written");
    let untouched = "t:60000 down 1 80 50\nt:60100 up 1\nt:60200 end";
    let _board = Board::start(folder.path(), "./built.toml", untouched);
    let in_turn = [
        "will be identified again",
        "pad identified: its readings are",
    ];
    play_until(folder.path(), &[], &in_turn);
}
