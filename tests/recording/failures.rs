//! Kills, full disks and damage: what was flushed is saved, and losses are reported.

use std::fs::{self, OpenOptions};
use std::io::{Seek as _, SeekFrom, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, ensure};

use crate::sessions::straight;
use crate::{gelpad_ends, printed, said};

/// Kills in a run of all tests; `GELPAD_KILLS=100` for the figure.
const KILLS: u64 = 3;
/// The setup is longer than this: matrix and table.
const SET_UP_BYTES: u64 = 1_000_000;

/// A script that presses until it is killed.
fn endless(folder: &Path) -> Result<()> {
    let mut script = String::new();
    for press in 0..100 {
        let t_ms = 300 + 150 * press;
        script.push_str(&format!(
            "t:{t_ms} down {press} 80 50\nt:{} up {press}\n",
            t_ms + 70
        ));
    }
    Ok(fs::write(folder.join("touches.txt"), script)?)
}

pub fn killed() -> Result<()> {
    let folder = tempfile::tempdir()?;
    endless(folder.path())?;
    let kills = match std::env::var("GELPAD_KILLS") {
        Ok(kills) => kills.parse()?,
        Err(_) => KILLS,
    };
    let mut frames = 0;
    let mut cut = 0;
    for kill in 0..kills {
        let (saved, was_cut) =
            kill_once(folder.path(), kill).with_context(|| format!("kill {kill}"))?;
        frames += saved;
        cut += u64::from(was_cut);
    }
    println!(
        "{kills} kills: {frames} frames flushed before them, all saved; {cut} files end within a record"
    );
    Ok(())
}

/// Kills a session at some moment; returns the number of saved frames, and whether the file ended within one.
fn kill_once(folder: &Path, kill: u64) -> Result<(u64, bool)> {
    let path = folder.join("k.mcap");
    let _ = fs::remove_file(&path);
    let mut child = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .args([
            "play",
            "--source",
            "simulated:touches.txt",
            "--output",
            "trace",
            "--headless",
            "--record",
            "k.mcap",
        ])
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()?;
    let wanted = 12 + kill * 7 % 50;
    loop {
        let length = fs::metadata(&path).map_or(0, |file| file.len());
        if length > SET_UP_BYTES && flushed(&path)?.0 >= wanted {
            break;
        }
        ensure!(child.try_wait()?.is_none(), "it ended early");
        thread::sleep(Duration::from_micros(2000 + 137 * kill));
    }
    child.kill()?;
    child.wait()?;
    let (frames, whole_bytes) = flushed(&path)?;
    let is_cut = whole_bytes < fs::metadata(&path)?.len();
    let output = gelpad_ends(
        folder,
        &["recover", "k.mcap", "-o", "saved.mcap"],
        if is_cut { 3 } else { 0 },
    )?;
    ensure!(
        said(&output).contains(&format!("saved.mcap: {frames} frames,")),
        "{frames} were flushed\n{}",
        said(&output)
    );
    ensure!(
        said(&output).contains("nothing was lost") != is_cut,
        "{}",
        said(&output)
    );
    let replayed = gelpad_ends(
        folder,
        &[
            "replay",
            "saved.mcap",
            "--expect",
            "saved.mcap",
            "--print",
            "touches",
        ],
        0,
    )?;
    ensure!(
        printed(&replayed).lines().count() as u64 == frames,
        "every saved frame replays"
    );
    Ok((frames, is_cut))
}

/// Frames of a live recording, and the length of its complete records, from the heads of the records (op code, eight bytes of
/// length) without gelpad's reader.
fn flushed(path: &Path) -> Result<(u64, u64)> {
    const MESSAGE: u8 = 5;
    let bytes = fs::read(path)?;
    let (mut at, mut frames) = (8, 0);
    while let Some(head) = bytes.get(at..at + 9) {
        let length = u64::from_le_bytes(head[1..].try_into()?) as usize;
        let Some(body) = bytes.get(at + 9..at + 9 + length) else {
            break;
        };
        // Frames are on the first channel.
        frames += u64::from(head[0] == MESSAGE && body[..2] == [1, 0]);
        at += 9 + length;
    }
    Ok((frames, at as u64))
}

pub fn full_disk() -> Result<()> {
    let folder = tempfile::tempdir()?;
    endless(folder.path())?;
    // A limit of the file size stands for a full disk: the setup and about fifty frames fit.
    straight(&folder.path().join("s.mcap"), 10, false)?;
    let blocks = fs::metadata(folder.path().join("s.mcap"))?.len() / 1024 + 60;
    fs::write(
        folder.path().join("touches.txt"),
        "t:600 down 1 80 50\nt:700 up 1\nt:2500 end\n",
    )?;
    let play = format!(
        "trap '' XFSZ; ulimit -f {blocks}; exec '{}' play --source simulated:touches.txt --output trace --headless --record full.mcap",
        env!("CARGO_BIN_EXE_gelpad")
    );
    let output = Command::new("bash")
        .args(["-c", &play])
        .current_dir(folder.path())
        .output()?;
    let text = said(&output);
    ensure!(
        output.status.code() == Some(3),
        "{:?}\n{text}",
        output.status
    );
    ensure!(
        text.contains("the recording ends here, play goes on"),
        "{text}"
    );
    ensure!(
        text.contains("251 frames, 1 press"),
        "it played to its end\n{text}"
    );
    let saved = gelpad_ends(
        folder.path(),
        &["recover", "full.mcap", "-o", "saved.mcap"],
        0,
    )?;
    ensure!(
        said(&saved).contains("nothing was lost"),
        "it ends with a whole frame\n{}",
        said(&saved)
    );
    gelpad_ends(
        folder.path(),
        &["replay", "full.mcap", "--expect", "full.mcap"],
        0,
    )?;
    Ok(())
}

pub fn damaged() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("s.mcap");
    straight(&path, 400, false)?;
    let length = fs::metadata(&path)?.len();
    let mut file = OpenOptions::new().write(true).open(&path)?;
    // About a hundred frames before the end, across the head of a record.
    file.seek(SeekFrom::Start(length - 150_000))?;
    file.write_all(&[0xA5; 3000])?;
    drop(file);
    let text = said(&gelpad_ends(folder.path(), &["replay", "s.mcap"], 1)?);
    ensure!(text.contains("gelpad recover"), "{text}");
    let text = said(&gelpad_ends(
        folder.path(),
        &["recover", "s.mcap", "-o", "saved.mcap"],
        3,
    )?);
    let frames: u64 = text
        .split("saved.mcap: ")
        .nth(1)
        .and_then(|rest| rest.split(' ').next())
        .context("how many")?
        .parse()?;
    ensure!(
        (390..400).contains(&frames) && text.contains("lost: "),
        "{text}"
    );
    // What follows the damage may differ: this is reported as lost data.
    let text = said(&gelpad_ends(folder.path(), &["replay", "saved.mcap"], 3)?);
    ensure!(text.contains("missing in the recording"), "{text}");
    Ok(())
}
