//! Exports read by other programs: CSV, evemu, a movie in fceux, MCAP by its Python package.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use gelpad::app::timeline::RecordingTimeline;
use gelpad::tape::{RecordedItem, RecordingPlayer};

use crate::process::Process;
use crate::sessions::straight;
use crate::tools::Tools;
use crate::{gelpad_ends, printed, said};

const GAME: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/game");
/// Timeout for a busy machine.
const PATIENCE: Duration = Duration::from_mins(1);

pub fn texts() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let path = folder.path();
    straight(&path.join("s.mcap"), 300, true)?;
    gelpad_ends(
        path,
        &["export", "s.mcap", "--format", "csv", "-o", "s.csv"],
        0,
    )?;
    let own = printed(&gelpad_ends(
        path,
        &["replay", "s.mcap", "--print", "touches"],
        0,
    )?);
    let again = printed(&gelpad_ends(
        path,
        &["replay", "s.csv", "--print", "touches"],
        0,
    )?);
    ensure!(
        own.lines().count() == 300 && own == again,
        "the frames are the same to the bit"
    );
    gelpad_ends(
        path,
        &["export", "s.mcap", "--format", "evemu", "-o", "s.evemu"],
        0,
    )?;
    let evemu = fs::read_to_string(path.join("s.evemu"))?;
    let events = printed(&gelpad_ends(
        path,
        &["replay", "s.mcap", "--print", "events"],
        0,
    )?);
    // Key 33 is f.
    let presses = evemu
        .lines()
        .filter(|line| line.ends_with("0001 0021 1"))
        .count();
    ensure!(
        presses > 0 && presses == events.matches("press key:f").count(),
        "{evemu}"
    );
    let text = said(&gelpad_ends(
        path,
        &["export", "s.csv", "--format", "csv", "-o", "t.csv"],
        1,
    )?);
    ensure!(text.contains("not a recording"), "{text}");
    Ok(())
}

/// A part that begins within a press contains the press, and one that begins at rest only itself.
pub fn part_within_a_press() -> Result<()> {
    /// First and last frame, and presses: the finger is down from frame 100 to 120 and from 140 to 160.
    const PARTS: [(usize, usize, usize); 3] = [(110, 170, 2), (104, 130, 1), (125, 135, 0)];
    let folder = tempfile::tempdir()?;
    let path = folder.path();
    straight(&path.join("s.mcap"), 200, true)?;
    let file = BufReader::new(File::open(path.join("s.mcap"))?);
    let (mut player, config) = RecordingPlayer::open(file)?;
    let mut timeline = RecordingTimeline::new(config.pad.clone(), config.engine());
    while let Some(item) = player.next()? {
        if let RecordedItem::Input(input) = item {
            timeline.add_input(&input);
        }
    }
    for (from, to, presses) in PARTS {
        let text = timeline.csv(from..=to);
        if presses == 0 {
            ensure!(text.lines().count() == to - from + 2, "only the part");
        }
        fs::write(path.join("part.csv"), text)?;
        let events = printed(&gelpad_ends(path, &["replay", "part.csv"], 0)?);
        let found = events.matches(" press key:f").count();
        ensure!(
            found == presses,
            "{found} presses in the part from {from} to {to}, not {presses}:\n{events}"
        );
    }
    Ok(())
}

pub fn python() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let path = folder.path();
    straight(&path.join("s.mcap"), 300, true)?;
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/recording/read_mcap.py");
    let output = crate::python()
        .arg(script)
        .arg(path.join("s.mcap"))
        .output()?;
    ensure!(output.status.success(), "{}", said(&output));
    let text = printed(&output);
    let events = printed(&gelpad_ends(
        path,
        &["replay", "s.mcap", "--print", "events"],
        0,
    )?);
    let line = format!("/event {}", events.lines().count());
    ensure!(
        text.lines().any(|text| text == line),
        "no `{line}` in\n{text}"
    );
    ensure!(text.lines().any(|text| text == "frames 300"), "{text}");
    Ok(())
}

pub fn no_fceux() -> Option<String> {
    Tools::find().err().map(|missing| missing.to_string())
}

/// In every frame the game polls the exported buttons.
pub fn movie() -> Result<()> {
    let tools = Tools::find()?;
    let folder = tempfile::tempdir()?;
    let path = folder.path();
    straight(&path.join("s.mcap"), 600, true)?;
    gelpad_ends(
        path,
        &[
            "export",
            "s.mcap",
            "--format",
            "fm2",
            "--start-frame",
            "90",
            "-o",
            "s.fm2",
        ],
        0,
    )?;
    let movie = rows(&path.join("s.fm2"))?;
    ensure!(
        movie.iter().any(|row| row.contains('A')) && movie.len() > 300,
        "a movie with jumps"
    );
    let game = assemble(&tools, path)?;
    let (_server, display) = server(&tools, path)?;
    let log = path.join("log.csv");
    let mut fceux = Command::new(&tools.fceux);
    fceux
        .env("DISPLAY", &display)
        .env("HOME", path)
        .env("XDG_RUNTIME_DIR", path)
        .env_remove("WAYLAND_DISPLAY")
        .env("QT_QPA_PLATFORM", "xcb")
        .env("GELPAD_GAME_LOG", &log)
        .args(["--no-config", "1", "--sound", "0"])
        .arg("--playmov")
        .arg(path.join("s.fm2"))
        .args(["--loadlua", &format!("{GAME}/log.lua")])
        .arg(game);
    let mut fceux = Process::start("fceux", &mut fceux, path)?;
    let seen = fceux.wait_for("the movie's end", 2 * PATIENCE, || {
        let seen = seen(&log)?;
        Ok(seen.contains_key(&movie.len()).then_some(seen))
    })?;
    for (index, row) in movie.iter().enumerate() {
        let frame = index + 1;
        let saw = seen
            .get(&frame)
            .with_context(|| format!("frame {frame} is not in the log"))?;
        ensure!(
            row == saw,
            "frame {frame}: the movie says {row}, the game saw {saw}"
        );
    }
    println!("fceux: {} frames, all as exported", movie.len());
    Ok(())
}

/// The buttons of each frame of a movie.
fn rows(path: &Path) -> Result<Vec<String>> {
    let text = fs::read_to_string(path)?;
    let rows = text.lines().filter_map(|line| line.strip_prefix("|0|"));
    Ok(rows
        .map(|row| row.trim_end_matches('|').to_owned())
        .collect())
}

/// The buttons that the game polled in each frame, counted from 1, in the letters of the movie.
fn seen(log: &Path) -> Result<BTreeMap<usize, String>> {
    let text = fs::read_to_string(log).unwrap_or_default();
    let mut lines = text
        .split_inclusive('\n')
        .filter_map(|line| line.strip_suffix('\n'));
    let Some(header) = lines.next() else {
        return Ok(BTreeMap::new());
    };
    let columns: Vec<&str> = header.split(',').collect();
    let place = |name: &str| {
        columns
            .iter()
            .position(|column| *column == name)
            .context("a column")
    };
    let order = ["right", "left", "down", "up", "start", "select", "B", "A"];
    let places: Vec<usize> = order
        .iter()
        .map(|name| place(name))
        .collect::<Result<_>>()?;
    let frame = place("frame")?;
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let letters = places.iter().zip("RLDUTSBA".chars());
            let letter = |(place, letter): (&usize, char)| {
                if cells.get(*place) == Some(&"1") {
                    letter
                } else {
                    '.'
                }
            };
            let number: usize = cells.get(frame).context("a frame")?.parse()?;
            Ok((number, letters.map(letter).collect()))
        })
        .collect()
}

fn assemble(tools: &Tools, folder: &Path) -> Result<PathBuf> {
    let (object, game) = (folder.join("jump.o"), folder.join("jump.nes"));
    let mut ca65 = Command::new(&tools.ca65);
    ca65.arg(format!("{GAME}/jump.s")).arg("-o").arg(&object);
    Process::start("ca65", &mut ca65, folder)?.succeed(PATIENCE)?;
    let mut ld65 = Command::new(&tools.ld65);
    ld65.args(["-C", &format!("{GAME}/nrom.cfg")])
        .arg(&object)
        .arg("-o")
        .arg(&game);
    Process::start("ld65", &mut ld65, folder)?.succeed(PATIENCE)?;
    Ok(game)
}

/// An X server on a display that it chooses itself.
fn server(tools: &Tools, folder: &Path) -> Result<(Process, OsString)> {
    let answer = folder.join("display");
    let mut xvfb = Command::new(&tools.xvfb);
    xvfb.args([
        "-displayfd",
        "1",
        "-nolisten",
        "tcp",
        "-noreset",
        "-screen",
        "0",
        "640x480x24",
    ]);
    let mut server = Process::start_answering("Xvfb", &mut xvfb, folder, &answer)?
        .with_grace(Duration::from_secs(2));
    let number = server.wait_for("display number", PATIENCE, || {
        let text = fs::read_to_string(&answer)?;
        Ok(text.strip_suffix('\n').map(str::to_owned))
    })?;
    Ok((server, format!(":{number}").into()))
}
