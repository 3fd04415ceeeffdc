//! A replay equals its recording on any processor and at any speed.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{BufReader, BufWriter};
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use anyhow::{Context, Result, ensure};
use gelpad::engine::Input;
use gelpad::session::{Message, Reader, RecordingSummary, Setup};
use gelpad::source::{FramesCsv, RoundedSource, Source, SourceError, SourcePace, SourceReading};
use gelpad::tape::{EngineConfig, SessionWriter};
use gelpad::touch::correction::Component;
use gelpad::touch::{Correction, CorrectionData};

use crate::sessions::{Frames, config, eventful, step, straight};
use crate::{gelpad_ends, printed, said};

/// Largest size of a frame of 208 channels, bytes. The noise of session.csv alone takes 402.
const MOST_BYTES_A_FRAME: u64 = 480;
/// Largest recordings of the session, bytes.
const MOST_BYTES: u64 = 4_000_000;
const MOST_BYTES_SLIM: u64 = 400_000;
const SESSION: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/tests/data/lattice-presses/session.csv"
);

pub fn to_the_bit() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("session.mcap");
    eventful(&path)?;
    let counts = counts(&path)?;
    for (what, count) in [
        ("lost frames", counts.lost),
        ("profiles", counts.profiles),
        ("re-zeros", counts.rezeros),
        ("matrices", counts.matrices),
        ("events", counts.events),
        ("frames with touches", counts.touches),
    ] {
        ensure!(count > 0, "the session has no {what}: nothing is tried");
    }
    for _ in 0..4 {
        replay_exactly(folder.path())?;
    }
    // The fifth time all cores are busy.
    let busy = Arc::new(AtomicBool::new(true));
    let cores = 2 * thread::available_parallelism()?.get();
    let threads: Vec<_> = (0..cores)
        .map(|_| {
            let busy = Arc::clone(&busy);
            thread::Builder::new()
                .name("busy".to_owned())
                .spawn(move || while busy.load(Ordering::Relaxed) {})
                .expect("a thread")
        })
        .collect();
    let outcome = replay_exactly(folder.path());
    busy.store(false, Ordering::Relaxed);
    threads
        .into_iter()
        .for_each(|thread| thread.join().expect("nothing but a loop"));
    outcome
}

/// Compares every event and every bit of every touch with the recorded ones.
fn replay_exactly(folder: &Path) -> Result<()> {
    let output = gelpad_ends(
        folder,
        &["replay", "session.mcap", "--expect", "session.mcap"],
        0,
    )?;
    ensure!(
        said(&output).contains("bit for bit"),
        "it did not compare\n{}",
        said(&output)
    );
    Ok(())
}

#[derive(Default)]
struct Counts {
    lost: u64,
    profiles: u64,
    rezeros: u64,
    matrices: u64,
    events: u64,
    touches: u64,
}

fn counts(path: &Path) -> Result<Counts> {
    let (mut reader, _) = Reader::open(BufReader::new(File::open(path)?))?;
    let mut counts = Counts::default();
    while let Some(message) = reader.next()? {
        match message {
            Message::Lost(lost) => counts.lost += lost.frames,
            Message::Profile(_) => counts.profiles += 1,
            Message::Rezero(_) => counts.rezeros += 1,
            Message::Matrix(_) => counts.matrices += 1,
            Message::Event(_) => counts.events += 1,
            Message::Touches(_) => counts.touches += 1,
            Message::TouchBlock(block) => counts.touches += block.frames.len() as u64,
            _ => {}
        }
    }
    ensure!(reader.is_whole(), "the file was closed");
    Ok(counts)
}

/// What a calibration learns from does not depend on the calibration in use.
pub fn uncorrected_contacts() -> Result<()> {
    let plain = config();
    let channels = plain.pad.channels();
    let component = |variance| Component {
        length: 1e4,
        variance,
    };
    let data = CorrectionData {
        size_mm: plain.pad.outline.size_mm(),
        gains: vec![1.0; channels],
        places_mm: vec![[50.0, 50.0]],
        signatures: vec![0.0; channels],
        weights_mm: vec![[-5.0, 0.0]],
        place: component(1.0),
        voltages: component(0.0),
        force_power: 1.0,
    };
    let shifted = EngineConfig {
        correction: Some(Correction::new(data)?),
        ..plain.clone()
    };
    let (mut plain, mut shifted) = (plain.engine(), shifted.engine());
    let mut pressed = 0;
    for frame in Frames::new(3).take(120) {
        let input = Input::Frame(frame);
        plain.input(&input, &mut Vec::new());
        shifted.input(&input, &mut Vec::new());
        let contacts = shifted.detector().uncorrected_contacts();
        ensure!(contacts == plain.detector().uncorrected_contacts());
        if let ([model], [touch]) = (plain.touches_down(), shifted.touches_down()) {
            let moved = touch.contact.centre_mm[0] - model.contact.centre_mm[0];
            ensure!((moved + 5.0).abs() < 0.1, "moved by {moved} mm");
            ensure!(contacts[0].centre_mm == model.contact.centre_mm);
            pressed += 1;
        }
    }
    ensure!(pressed > 10, "{pressed} frames with a touch");
    Ok(())
}

pub fn with_another_profile() -> Result<()> {
    let folder = tempfile::tempdir()?;
    straight(&folder.path().join("s.mcap"), 400, true)?;
    let events = |more: &[&str]| -> Result<String> {
        let arguments = [&["replay", "s.mcap", "--print", "events"], more].concat();
        Ok(printed(&gelpad_ends(folder.path(), &arguments, 0)?))
    };
    let (own, other) = (
        events(&[])?,
        events(&["--profile", "super-mario-nestopia"])?,
    );
    ensure!(
        own.contains("press key:f") && !own.contains("key:z"),
        "{own}"
    );
    ensure!(
        other.contains("press key:z") && !other.contains("key:f"),
        "{other}"
    );
    let times = |text: &str| -> Vec<String> {
        text.lines()
            .map(|l| l.split(' ').next().unwrap().to_owned())
            .collect()
    };
    ensure!(
        times(&own) == times(&other),
        "the same touches: {own}\n{other}"
    );
    // Another method gives other images and the same presses.
    let presses = |text: &str| text.matches("press").count();
    ensure!(
        presses(&events(&["--method", "tikhonov"])?) == presses(&own),
        "by another method"
    );
    Ok(())
}

pub fn expectations() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let path = folder.path();
    straight(&path.join("s.mcap"), 400, true)?;
    gelpad_ends(path, &["replay", "s.mcap", "--update", "s.events"], 0)?;
    gelpad_ends(
        path,
        &[
            "replay", "s.mcap", "--expect", "s.events", "--junit", "ok.xml",
        ],
        0,
    )?;
    ensure!(
        fs::read_to_string(path.join("ok.xml"))?.contains("failures=\"0\""),
        "a good verdict"
    );
    let events = fs::read_to_string(path.join("s.events"))?;
    let mut lines: Vec<String> = events.lines().map(str::to_owned).collect();
    ensure!(lines.len() >= 6, "a session of {} events", lines.len());
    let (t_ms, what) = lines[3].split_once(' ').context("an event")?;
    let later = format!("{:.3} {what}", t_ms.parse::<f64>()? + 7.0);
    let was = std::mem::replace(&mut lines[3], later.clone());
    fs::write(path.join("other.events"), lines.join("\n"))?;
    let output = gelpad_ends(
        path,
        &[
            "replay",
            "s.mcap",
            "--expect",
            "other.events",
            "--junit",
            "bad.xml",
        ],
        1,
    )?;
    let text = said(&output);
    for part in [
        "line 4",
        &format!("  - {later}"),
        &format!("  + {was}"),
        &format!("    {}", lines[2]),
    ] {
        ensure!(text.contains(part), "`{part}` is not in\n{text}");
    }
    ensure!(
        fs::read_to_string(path.join("bad.xml"))?.contains("<failure message="),
        "a bad verdict"
    );
    gelpad_ends(
        path,
        &[
            "replay",
            "s.mcap",
            "--expect",
            "other.events",
            "--tolerance-ms",
            "8",
        ],
        0,
    )?;
    // With another profile the recording itself is compared by its events, too.
    let other_profile = [
        "replay",
        "s.mcap",
        "--profile",
        "supertux",
        "--expect",
        "s.mcap",
    ];
    let output = gelpad_ends(path, &other_profile, 1)?;
    ensure!(said(&output).contains("the events differ at line 1"));
    Ok(())
}

pub fn stretch() -> Result<()> {
    let folder = tempfile::tempdir()?;
    straight(&folder.path().join("s.mcap"), 400, true)?;
    let all = printed(&gelpad_ends(folder.path(), &["replay", "s.mcap"], 0)?);
    let some = printed(&gelpad_ends(
        folder.path(),
        &["replay", "s.mcap", "--from", "1.5", "--to", "2.5"],
        0,
    )?);
    let inside = |line: &&str| {
        let t_ms: f64 = line.split(' ').next().unwrap().parse().unwrap();
        (1500.0..=2500.0).contains(&t_ms)
    };
    let expected: Vec<&str> = all.lines().filter(inside).collect();
    ensure!(
        !expected.is_empty() && some.lines().eq(expected),
        "{some} of {all}"
    );
    Ok(())
}

pub fn too_few() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let path = folder.path();
    straight(&path.join("s.mcap"), 9, true)?;
    let csv: String = fs::read_to_string(SESSION)?
        .split_inclusive('\n')
        .take(10)
        .collect();
    fs::write(path.join("s.csv"), csv)?;
    for file in ["s.mcap", "s.csv"] {
        let text = said(&gelpad_ends(path, &["replay", file], 1)?);
        ensure!(
            text.contains("only 9 frames: the first 10 are the reference"),
            "{text}"
        );
    }
    Ok(())
}

pub fn as_source() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let path = folder.path();
    straight(&path.join("s.mcap"), 200, true)?;
    let play = [
        "play",
        "--source",
        "replay:s.mcap",
        "--output",
        "trace",
        "--headless",
    ];
    let played = printed(&gelpad_ends(path, &play, 0)?);
    let replayed = printed(&gelpad_ends(path, &["replay", "s.mcap"], 0)?);
    let presses = |text: &str| -> Vec<String> {
        text.lines()
            .filter(|line| line.contains("press key:f"))
            .map(str::to_owned)
            .collect()
    };
    ensure!(
        presses(&played).len() > 1 && presses(&played) == presses(&replayed),
        "{played} of {replayed}"
    );
    let onto_itself = [&play[..], &["--record", "s.mcap"]].concat();
    let text = said(&gelpad_ends(path, &onto_itself, 1)?);
    ensure!(text.contains("this recording is being played"), "{text}");
    Ok(())
}

/// A session of 30 s at 100 frames/s, half of them with fingers: sizes, and every frame to the bit.
pub fn size() -> Result<()> {
    let setup = config().to_setup();
    let source = FramesCsv::open(Path::new(SESSION), config().pad.channels())?;
    let (whole, frames) = recorded_size(&setup, Box::new(source))?;
    let (empty, _) = recorded_size(&setup, Box::new(Nothing))?;
    let a_frame = (whole - empty) / frames;
    println!("session.csv: {whole} bytes, {a_frame} a frame, with touches, events and index");
    ensure!(a_frame <= MOST_BYTES_A_FRAME, "{a_frame} bytes a frame");
    ensure!(whole <= MOST_BYTES, "{whole} bytes for {frames} frames");
    let source = FramesCsv::open(Path::new(SESSION), config().pad.channels())?;
    let rounded = Box::new(RoundedSource::new(Box::new(source)));
    let (slim, frames) = recorded_size(&setup.into_slim("noser"), rounded)?;
    println!("session.csv: {slim} bytes slim");
    ensure!(slim <= MOST_BYTES_SLIM, "{slim} bytes for {frames} frames");
    Ok(())
}

/// A source that has ended.
struct Nothing;

impl Source for Nothing {
    fn pace(&self) -> SourcePace {
        SourcePace::ByStamp
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        Ok(SourceReading::End)
    }
}

/// Records a source: bytes of the packed file without matrices that replace the first, and frames.
fn recorded_size(setup: &Setup, mut source: Box<dyn Source>) -> Result<(u64, u64)> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("s.mcap");
    let mut writer = SessionWriter::packed(BufWriter::new(File::create(&path)?), setup)?;
    let mut engine = config().engine();
    let mut frames = Vec::new();
    while let SourceReading::Frame(frame) = source.read()? {
        frames.push(frame.clone());
        step(&mut engine, &Input::Frame(frame), &mut writer)?;
    }
    writer.finish()?;
    let summary = RecordingSummary::read(&path).expect("an index");
    // One of the recordings has no frames.
    let first_and_last = frames.first().zip(frames.last());
    let length_ns = first_and_last.map_or(0, |(first, last)| last.t_ns - first.t_ns);
    // The frames of a block share the time of the first.
    let shorter_ns = length_ns - summary.length.as_nanos() as u64;
    assert!(shorter_ns < 500_000_000, "{:?}", summary.length);
    assert_eq!(summary.profile.as_deref(), Some("super-mario"));
    let (mut reader, _) = Reader::open(BufReader::new(File::open(&path)?))?;
    let mut back = Vec::new();
    while let Some(message) = reader.next()? {
        if let Message::Frames(block) = message {
            back.extend(block);
        }
    }
    ensure!(back == frames, "the frames come back to the bit");
    Ok((fs::metadata(&path)?.len(), frames.len() as u64))
}

const GUEST: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/run-in-guest.sh");

pub fn no_guest() -> Option<String> {
    let ready = Command::new(GUEST).arg("--prepare").output();
    let is_ready = ready.is_ok_and(|output| output.status.success());
    (!is_ready).then(|| "no guest: scripts/run-in-guest.sh --prepare".to_owned())
}

/// The guest's processor has no AVX2; its sums equal those of the host.
pub fn in_guest() -> Result<()> {
    // The guest has a /tmp of its own.
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR"))?;
    let path = folder.path().join("session.mcap");
    eventful(&path)?;
    replay_in_guest(&path, &["--expect".as_ref(), path.as_ref()])
}

/// The guest solves what a slim recording leaves out, and plays the same events.
pub fn slim_in_guest() -> Result<()> {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR"))?;
    let (path, events) = (
        folder.path().join("slim.mcap"),
        folder.path().join("slim.events"),
    );
    let presses = (0..12).map(|press| {
        let (down, up) = (500 + 250 * press, 600 + 250 * press);
        format!("t:{down} down 1 {} 50\nt:{up} up 1\n", 78 + press % 4)
    });
    fs::write(
        folder.path().join("touches.txt"),
        presses.collect::<String>(),
    )?;
    let play = [
        "play",
        "--source",
        "simulated:touches.txt",
        "--output",
        "trace",
    ];
    let record = ["--headless", "--slim", "--record", "slim.mcap"];
    gelpad_ends(folder.path(), &[&play[..], &record].concat(), 0)?;
    let update = ["replay", "slim.mcap", "--update", "slim.events"];
    gelpad_ends(folder.path(), &update, 0)?;
    let presses = fs::read_to_string(&events)?.matches("press key").count();
    ensure!(presses >= 12, "{presses} presses");
    let tolerant = ["--tolerance-ms", "20", "--expect"].map(OsStr::new);
    replay_in_guest(&path, &[&tolerant[..], &[events.as_ref()]].concat())
}

fn replay_in_guest(path: &Path, arguments: &[&OsStr]) -> Result<()> {
    let output = Command::new(GUEST)
        .args(["--timeout", "600", env!("CARGO_BIN_EXE_gelpad"), "replay"])
        .arg(path)
        .args(arguments)
        .arg("-v")
        .output()?;
    ensure!(
        output.status.success(),
        "{:?}\n{}\n{}",
        output.status,
        printed(&output),
        said(&output)
    );
    Ok(())
}

/// An hour at 100 frames/s: how much faster than real time it replays on an idle machine.
#[allow(clippy::disallowed_methods, reason = "a figure, not a verdict")]
pub fn hour() -> Result<()> {
    let folder = tempfile::tempdir()?;
    straight(&folder.path().join("s.mcap"), 360_000, true)?;
    let size = fs::metadata(folder.path().join("s.mcap"))?.len();
    let start = std::time::Instant::now();
    gelpad_ends(
        folder.path(),
        &["replay", "s.mcap", "--expect", "s.mcap"],
        0,
    )?;
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "an hour ({} MB) replays in {seconds:.1} s: {:.0} times real time",
        size / 1_000_000,
        3600.0 / seconds
    );
    Ok(())
}
